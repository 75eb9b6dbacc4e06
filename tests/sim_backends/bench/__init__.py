"""Tests of the optical bench."""
