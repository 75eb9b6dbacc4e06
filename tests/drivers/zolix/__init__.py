"""Tests of the Zolix driver against scripted ports."""
