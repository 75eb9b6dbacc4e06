"""Tests of the ALP library emulator."""
