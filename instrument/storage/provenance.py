"""Who wrote a file, and when."""

import hashlib
from datetime import UTC, datetime
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path
from typing import Final

import instrument

PROGRAM = "kinopix"
"""Name of the program, as files carry it."""

_SHOWS: Final = ("cli", "views", "live", "web", "bluesky_devices")
"""Rooms that show what was computed, or ask for it, and do not change it."""


def now() -> str:
    """The time now, in UTC, as NeXus writes it (ISO 8601)."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def program_version() -> str:
    """Version of Kinopix that is installed."""
    return _version(PROGRAM)


@cache
def program() -> str:
    """Version of the program and of every library that computes, with a digest of the program's own text.

    The text is that of the packages beside this one: a change of a solver or of the simulated bench makes another program.
    """
    digest = hashlib.sha256()
    home = Path(str(instrument.__file__)).parent
    for package in ("protocols", "sim_backends", "instrument"):
        for path in sorted((home.parent / package).rglob("*.py")):
            if path.parent.parent == home and path.parent.name in _SHOWS:
                continue
            digest.update(path.relative_to(home.parent).as_posix().encode() + b"\0" + path.read_bytes())
    return " ".join(
        [*(f"{name} {_version(name)}" for name in (PROGRAM, "numpy", "scipy", "numba")), digest.hexdigest()]
    )


def _version(name: str) -> str:
    try:
        return version(name)
    except PackageNotFoundError:  # run from a folder, without installing
        return "unknown"
