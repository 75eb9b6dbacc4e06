"""Tests of the emulators that speak the devices' own calls and bytes."""
