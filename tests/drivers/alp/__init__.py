"""Tests of the ALP driver, on a scripted function table."""
