"""How long ``kinopix info`` takes on a large recording: ``python -m benchmarks.info [--gigabytes 1] [--repeats 7]``.

A recording of that size is written, as a run writes it, and then whole processes are timed in turn: ``kinopix info FILE``, and
``kinopix --help``, which does nothing else than start. Seconds of wall clock and of the processor are printed, the ratio of both,
and the same for a recording of one frame, so that what the size costs stands beside what the start costs. Python keeps what it
has compiled, as it does where Kinopix is installed: in a folder of this benchmark's own, filled by processes that do not count.
"""

import argparse
import os
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from statistics import median
from typing import Final

import numpy as np

from instrument.plan import Plan
from instrument.storage import RecordingWriter
from protocols import CountBlock

_BYTES_A_PATTERN: Final = 32
"""Raw counts, their edges, values, their edges: 8 bytes each."""
_PATTERNS_A_BLOCK: Final = 600_000
_MOST_S: Final = 0.5
"""What a look at a gigabyte may take."""


def written(path: Path, gigabytes: float) -> None:
    """Write a recording of so many gigabytes, of one frame at least, block by block."""
    per_frame = Plan(frames=1).patterns_per_frame
    frames = max(1, round(gigabytes * 1e9 / _BYTES_A_PATTERN / per_frame))
    plan = Plan(frames=frames)
    with RecordingWriter(path, plan, picture_time_s=plan.picture_time_s) as writer:
        for first in range(0, plan.patterns, _PATTERNS_A_BLOCK):
            index = np.arange(first, min(first + _PATTERNS_A_BLOCK, plan.patterns))
            counts = (1000 + index % 97).astype(np.uint32)
            edges = index.astype(np.float64) * plan.picture_time_s
            end_s = (int(index[-1]) + 1) * plan.picture_time_s
            block = CountBlock(first_bin=first, counts=counts, opening_edge_s=edges, closing_edge_s=end_s)
            writer.append_raw(block)
            writer.append(counts.astype(np.float64), edges)
        writer.finish()


def seconds(arguments: list[str], compiled: Path) -> tuple[float, float]:
    """Give wall clock and processor time of one process of ``python -m kinopix``, with a folder for what Python compiles."""
    environment = {name: value for name, value in os.environ.items() if name != "PYTHONDONTWRITEBYTECODE"}
    environment["PYTHONPYCACHEPREFIX"] = str(compiled)
    start_s, before = time.perf_counter(), os.times()
    subprocess.run([sys.executable, "-m", "kinopix", *arguments], capture_output=True, check=True, env=environment)
    after = os.times()
    used_s = after.children_user + after.children_system - before.children_user - before.children_system
    return time.perf_counter() - start_s, used_s


def main() -> None:
    """Print a line a recording."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--gigabytes", type=float, default=1.0, help="size of the large recording")
    parser.add_argument("--repeats", type=int, default=7, help="processes of each kind, after one that does not count")
    given = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        for gigabytes in (0.0, given.gigabytes):
            path = Path(folder) / f"{gigabytes:g}.h5"
            written(path, gigabytes)
            compiled = Path(folder) / "compiled"
            pairs = [
                (seconds(["info", str(path)], compiled), seconds(["--help"], compiled))
                for _ in range(given.repeats + 1)
            ][1:]
            info_s, info_used_s, help_s, help_used_s = (
                median(times) for times in zip(*((*info, *start) for info, start in pairs), strict=True)
            )
            ratio = median(info[1] / max(start[1], 1e-3) for info, start in pairs)
            print(
                f"{path.stat().st_size / 1e9:.3f} GB: kinopix info {info_s:.3f} s ({info_used_s:.3f} s of processor), "
                f"kinopix --help {help_s:.3f} s ({help_used_s:.3f} s), ratio of processor time {ratio:.2f}, "
                f"at most {_MOST_S:g} s: {'yes' if info_s <= _MOST_S else 'NO'}, load {os.getloadavg()[0]:.1f}"
            )


if __name__ == "__main__":
    main()
