"""Analogue detectors (PMT with preamplifier, photodiode, APD) on NI analogue input: light and sync sampled by one task."""
