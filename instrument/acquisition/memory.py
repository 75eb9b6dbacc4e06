"""Whether a run and its analysis fit into the memory of this computer."""

import os
from contextlib import suppress
from pathlib import Path
from typing import Final

from instrument.plan import Plan
from instrument.schemes import scheme_of

PROGRAM_BYTES: Final = 230_000_000
"""The program itself, with numpy, scipy and compiled loops: 213 MB, measured."""

RECORDED_BYTES: Final = 128
"""One pattern while it is recorded, and read back at the end: 62 bytes, measured; twice that for safety."""

PATTERN_BYTES: Final = 1024
"""Counts, times, variances and estimates of one pattern while all are analysed at once, and not in windows: 500 bytes, measured;
twice that for safety."""

PIXEL_BYTES: Final = 2.5
"""For each pixel of each frame's Hadamard pattern, while patterns are made: 70 MB for 1,666 patterns of 128 x 128, measured."""


def recording_bytes(plan: Plan) -> int:
    """Give the memory that a run of a plan takes, in bytes."""
    return _bytes(plan, RECORDED_BYTES)


def analysis_bytes(plan: Plan) -> int:
    """Give the memory that a run of a plan and the analysis of its recording, all at once, take, in bytes."""
    return _bytes(plan, PATTERN_BYTES)


def _bytes(plan: Plan, of_a_pattern: int) -> int:
    unique = min(plan.frames, plan.image_size**2) if scheme_of(plan).image_rows is not None else 0
    return round(PROGRAM_BYTES + of_a_pattern * plan.patterns + PIXEL_BYTES * unique * plan.image_size**2)


def available_bytes(proc: Path = Path("/proc/meminfo"), group: Path = Path("/sys/fs/cgroup")) -> int | None:
    """Give the memory that a new program can have here, in bytes; None where the system does not tell.

    Args:
        proc: where Linux tells what is available.
        group: where Linux tells what the control group of a container may have (version 2).
    """
    found: list[int] = []
    with suppress(OSError, ValueError, LookupError):
        lines = dict(line.split(":", 1) for line in proc.read_text(encoding="ascii").splitlines())
        found.append(1024 * int(lines["MemAvailable"].split()[0]))
    with suppress(OSError, ValueError):
        most, now = ((group / name).read_text(encoding="ascii") for name in ("memory.max", "memory.current"))
        found.append(max(0, int(most) - int(now)))  # "max" is no number: no limit
    if not found and hasattr(os, "sysconf"):
        with suppress(OSError, ValueError):
            found.append(os.sysconf("SC_PHYS_PAGES") * os.sysconf("SC_PAGE_SIZE"))
    return min(found, default=None)
