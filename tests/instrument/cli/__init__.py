"""Tests of the kinopix command."""
