"""A photon counter on a serial line, by the one-page protocol of docs/reference/serial-counter.md."""
