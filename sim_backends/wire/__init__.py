"""Emulators that speak each device's own bytes or calls, so that the real drivers run without hardware."""
