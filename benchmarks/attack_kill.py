"""``kill -9`` at random moments of a run in real time at 20 kHz: what the file holds, against what the counter had given.

``killed(moments, seed)`` gives a row for each moment. The run is a script on the simulated bench that notes after each block, on
a pipe, how many bins the counter has given; the kill falls anywhere, also between two of HDF5's writes.
"""

import random
import signal
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from instrument.storage import open_recording, recover
from protocols import MonotonicClock

RATE_HZ: Final = 20_000

_RUN: Final = """
import os, sys, time
from instrument.config import bench_of_tables
from instrument.plan import Plan
from instrument.session import Instrument

plan = Plan(frames=8000, pattern_rate_hz=20_000, image_size=32, superpixel=4)
simulated = {name: {"driver": "simulated"} for name in ("modulator", "counter", "stage")}
scene = {"realtime": True, "noise": {"kind": "pixel", "sigma": 0.1, "seed": int(sys.argv[2])}}
with Instrument.from_config(bench_of_tables({**simulated, "scene": scene}, "attack")) as bench:
    read, given = bench.counter.read, 0

    def reading(timeout_s):
        global given
        block = read(timeout_s)
        given += len(block)
        os.write(1, f"{given} {time.monotonic():.4f}\\n".encode())
        return block

    bench.counter.read = reading
    bench.run(plan, sys.argv[1])
"""


@dataclass(frozen=True)
class Row:
    """One kill."""

    moment_s: float
    """After the first block."""

    given: int
    """Bins that the counter had given."""

    kept: int
    """Patterns that the file holds, as it was left; 0 where there is none yet, -1 where it does not open."""

    recovered: int
    """Patterns after ``recover``."""

    handed_over_in_s: float
    """Time in which the counter gave the last 0.2 s of them: far less where the run was held up, and caught up."""

    @property
    def lost_s(self) -> float:
        """Time of the run that is lost, s."""
        return (self.given - self.kept) / RATE_HZ

    @property
    def good(self) -> bool:
        """Whether the file opens and lacks at most 0.1 s."""
        return self.kept >= 0 and self.lost_s <= 0.1 and self.recovered >= self.kept


def killed(moments: int, seed: int) -> list[Row]:
    """Kill runs at random moments, and read what they left."""
    rng, clock = random.Random(seed), MonotonicClock()
    rows = list[Row]()
    with tempfile.TemporaryDirectory(prefix="kinopix-attack-") as name:
        for number in range(moments):
            out, moment_s = Path(name) / f"run-{number}.h5", 2.2 * rng.random()
            with subprocess.Popen([sys.executable, "-c", _RUN, str(out), str(seed)], stdout=subprocess.PIPE) as run:
                pipe = run.stdout
                if pipe is None:
                    raise RuntimeError("no pipe")
                notes = [pipe.readline()]
                clock.sleep_s(moment_s)
                run.send_signal(signal.SIGKILL)
                notes += [line for line in pipe.read().splitlines(keepends=True) if line.endswith(b"\n")]
            bins, times_s = zip(*(map(float, note.split()) for note in notes), strict=True)
            late = [time_s for given, time_s in zip(bins, times_s, strict=True) if given > bins[-1] - 0.2 * RATE_HZ]
            rows.append(Row(moment_s, int(bins[-1]), *_kept(out), handed_over_in_s=late[-1] - late[0]))
            for left in out.parent.glob(f"{out.name}*"):
                left.unlink()
    return rows


def _kept(out: Path) -> tuple[int, int]:
    if not out.exists():  # the first block was on its way
        return 0, 0
    try:
        kept = _measured(out)
        done = recover(out)
    except Exception:  # noqa: BLE001 - whatever it is, the file does not open
        return -1, -1
    return kept, kept if done is None else done.patterns


def _measured(out: Path) -> int:
    values = open_recording(out).values.ravel()
    return int((values == values).sum())  # noqa: PLR0124 - NaN is not itself
