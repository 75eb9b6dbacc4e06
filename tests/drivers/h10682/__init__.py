"""Tests of what the drivers of an H10682 head share."""
