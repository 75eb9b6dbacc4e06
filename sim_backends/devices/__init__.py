"""Simulated equivalents of the three devices, on the optical bench."""
