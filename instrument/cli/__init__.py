"""The `kinopix` command."""

from instrument.cli.main import main

__all__ = ["main"]
