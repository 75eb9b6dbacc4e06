"""The name of a recording for which nobody gave one."""

from datetime import UTC, datetime
from itertools import count
from pathlib import Path


def next_name(folder: Path) -> Path:
    """Give the name of a file that is not there yet: ``run-DATE-TIME.h5`` by the clock (UTC), with ``-2`` and so on where it is.

    Args:
        folder: where the recording is to lie.
    """
    name = f"run-{datetime.now(UTC):%Y%m%d-%H%M%S}"
    return next(
        path
        for number in count(1)
        if not (path := folder / (f"{name}.h5" if number == 1 else f"{name}-{number}.h5")).exists()
    )
