"""Telling which native libraries a bench.toml has loaded: they are run with all rights of whoever runs the command."""

from pathlib import Path


def tell_libraries(bench: Path) -> None:
    """Print a line for each library that bench.toml names, before any of them is loaded.

    Raises:
        ConfigError: mistakes in bench.toml.
    """
    from instrument.config import load_bench
    from instrument.views import warn

    for role, device in load_bench(bench).devices.items():
        library = getattr(device.settings, "library", None)
        if library is not None:
            warn(
                f"[{role}] library = {str(library)!r}: native code, which {bench} has this computer run with all your rights"
            )
