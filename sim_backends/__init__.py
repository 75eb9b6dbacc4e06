"""What stands in for hardware: an optical bench, simulated devices on it, and emulators of the wire."""
