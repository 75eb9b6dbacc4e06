"""Checks that the type checkers run, and nobody else."""
