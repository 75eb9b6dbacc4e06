"""Telling which native libraries a bench.toml has loaded: they are run with all rights of whoever runs the command."""

from collections.abc import Collection
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from instrument.roles import RoleName


def tell_libraries(bench: Path, needed: "Collection[RoleName] | None" = None) -> None:
    """Print a line for each library that bench.toml names, before any of them is loaded.

    Args:
        bench: the file.
        needed: roles that the file must have; None for all.

    Raises:
        ConfigError: mistakes in bench.toml.
    """
    from instrument.config import load_bench
    from instrument.views import warn

    config = load_bench(bench) if needed is None else load_bench(bench, needed, calibrated=False)
    for role, device in config.devices.items():
        library = getattr(device.settings, "library", None)
        if library is not None:
            warn(
                f"[{role}] library = {str(library)!r}: native code, which {bench} has this computer run with all your rights"
            )
