"""Tests of the real drivers, without hardware."""
