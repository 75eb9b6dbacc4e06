"""Tests of the Zolix controller emulators."""
