"""Real hardware: one folder a device, one file a transport or dialect. Found by entry point, never imported above."""
