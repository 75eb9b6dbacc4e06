"""Disks that fail in the middle of a run: what the command says, how long it takes, and whether every count is kept.

``disk_full(moments, seed)`` gives a row for each moment of a run in real time at 20 kHz. The disk is a real limit of the system,
set while the run goes on: ``RLIMIT_FSIZE``, whose signal Python ignores, refuses every write beyond a size, as a full disk does.
``cut(moments, seed)`` cuts the file instead, as another program might. Linux only (``prlimit``).
"""

import contextlib
import io
import os
import random
import re
import subprocess
import sys
import tempfile
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import h5py  # pyright: ignore[reportMissingTypeStubs]
import numpy as np

from benchmarks.simulated import bench_text, plan_text, run_command
from instrument.cli.main import status
from instrument.plan import Plan
from instrument.session import Instrument
from protocols import MonotonicClock

if sys.platform != "win32":
    import resource

FRAMES: Final = 8000
"""48,000 patterns: 2.4 s, and 1.9 MB of recording."""

_HANGS_S: Final = 10.0


@dataclass(frozen=True)
class Row:
    """One attack and what came of it."""

    moment: str
    """What was done, and when."""

    exit_code: int
    """Of ``kinopix run``; 3 is right."""

    paragraphs: int
    """Errors that were told; 1 is right."""

    ended_s: float
    """From the attack to the end of the command."""

    patterns: int
    """Patterns that the command said it had counted."""

    recovered: int
    """Patterns in the recording after ``kinopix recover``."""

    exact: bool
    """Whether all of these are, to the bit, those of an undisturbed run of the same seed."""

    said: str
    """What the command said."""

    @property
    def good(self) -> bool:
        """Whether nothing was lost, all was told once, and nothing hung."""
        told = self.exit_code == 3 and self.paragraphs == 1 and "Traceback" not in self.said
        return told and self.ended_s <= _HANGS_S and self.exact and self.recovered == self.patterns


def disk_full(moments: int, seed: int, frames: int = FRAMES) -> list[Row]:
    """Let the disk be full at random moments of a run, and recover each time."""

    def fill(process: int, out: Path, rng: random.Random) -> str:
        limit = out.stat().st_size + rng.choice((0, rng.randrange(1 << 17)))
        resource.prlimit(process, resource.RLIMIT_FSIZE, (limit, limit))
        return f"full at {limit} bytes"

    return _attacks(fill, moments, seed, frames)


def cut(moments: int, seed: int, frames: int = FRAMES) -> list[Row]:
    """Cut the file at random moments and lengths. What others destroy is not recovered; that the run ends well is what counts."""

    def shorten(_process: int, out: Path, rng: random.Random) -> str:
        size = rng.choice((0, rng.randrange(out.stat().st_size)))
        os.truncate(out, size)
        return f"cut to {size} bytes"

    return _attacks(shorten, moments, seed, frames)


def _attacks(attack: Callable[[int, Path, random.Random], str], moments: int, seed: int, frames: int) -> list[Row]:
    rng, clock = random.Random(seed), MonotonicClock()
    with tempfile.TemporaryDirectory(prefix="kinopix-attack-") as name:
        bench = Bench(Path(name), seed, frames)
        out, rows = bench.folder / "run.h5", list[Row]()
        for _ in range(moments):
            delay_s = rng.random() * (frames * 6 / 20_000 - 0.3)
            with subprocess.Popen(
                run_command(bench.folder, out), stderr=subprocess.PIPE, stdout=subprocess.DEVNULL, text=True
            ) as run:
                while not out.exists() and run.poll() is None:
                    clock.sleep_s(0.005)
                clock.sleep_s(delay_s)
                done = attack(run.pid, out, rng)
                begun_s = clock.now_s()
                _, said = run.communicate(timeout=120)
                ended_s = clock.now_s() - begun_s
            rows.append(bench.row(f"{done} after {delay_s:.2f} s", run.returncode, said, ended_s))
    return rows


class Bench:
    """A folder with a simulated bench, a plan and an undisturbed recording."""

    def __init__(self, folder: Path, seed: int, frames: int = FRAMES) -> None:
        """Write both files and record undisturbed, in virtual time: the values are the same."""
        self.folder = folder
        noise, plan = f'noise = {{ kind = "pixel", sigma = 0.1, seed = {seed} }}', folder / "plan.toml"
        (folder / "virtual.toml").write_text(bench_text(noise), encoding="utf-8")
        (folder / "bench.toml").write_text(bench_text(noise, realtime=True), encoding="utf-8")
        plan.write_text(plan_text(frames, image_size=32, velocity_mm_s=1.0), encoding="utf-8")
        with Instrument.from_toml(folder / "virtual.toml") as bench:
            recording = bench.run(Plan.from_toml(plan), folder / "undisturbed.h5")
        self.values = recording.values.ravel()

    def row(self, moment: str, exit_code: int, said: str, ended_s: float) -> Row:
        """Recover ``run.h5`` and judge it; then everything is removed."""
        out = self.folder / "run.h5"
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            status(["recover", str(out)])
        values = values_of(out) if out.exists() else np.empty(0)
        counted = re.search(r"(\d+) of \d+ patterns were counted", said)
        for left in self.folder.glob("*run.h5*"):
            left.unlink()
        exact = bool(np.array_equal(values, self.values[: len(values)]))
        patterns = int(counted[1]) if counted else 0
        return Row(moment, exit_code, said.count("kinopix: "), ended_s, patterns, len(values), exact, said)


def values_of(path: Path) -> np.ndarray[tuple[int], np.dtype[np.float64]]:
    """Give the values of a closed recording, in play order, as h5py alone reads them."""
    try:
        with h5py.File(path) as file:
            values = np.asarray(file["entry/data/values"], np.float64).ravel()
    except OSError:
        return np.empty(0)
    return values[np.isfinite(values)]
