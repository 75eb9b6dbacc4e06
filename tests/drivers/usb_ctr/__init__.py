"""Tests of the USB-CTR driver: the codec against the protocol's own bytes, the driver against a scripted board."""
