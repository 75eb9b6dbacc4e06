"""Tests of checks, runs, alignment and audit."""
