"""How a stepper and its carriage move, and what its controller counts: shared by the emulators of stage controllers."""
