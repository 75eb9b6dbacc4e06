"""Stages on a GRBL 1.1 controller (fact sheet zaber-and-grbl, section 3), written without a device at hand."""
