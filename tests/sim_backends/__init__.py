"""Tests of what stands in for hardware."""
