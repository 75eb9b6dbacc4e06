"""Tests of the KA400Z driver against scripted ports."""
