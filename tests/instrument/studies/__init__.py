"""Studies of the paper."""
