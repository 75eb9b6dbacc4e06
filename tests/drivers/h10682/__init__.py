"""Tests of the H10682 drivers: the codec against the protocol's own bytes, the drivers against scripted hardware."""
