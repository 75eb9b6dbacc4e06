"""Who wrote a file, and when."""

from datetime import UTC, datetime
from importlib.metadata import PackageNotFoundError, version

PROGRAM = "kinopix"
"""Name of the program, as files carry it."""


def now() -> str:
    """The time now, in UTC, as NeXus writes it (ISO 8601)."""
    return datetime.now(UTC).isoformat(timespec="milliseconds")


def program_version() -> str:
    """Version of Kinopix that is installed."""
    try:
        return version(PROGRAM)
    except PackageNotFoundError:  # run from a folder, without installing
        return "unknown"
