"""Many recordings on one process and on two, in turn, and the ratio: ``python -m benchmarks.many [--recordings 100]``.

Copies of four runs of the simulated bench, 64 x 64 pixels, analysed with every default; new processes and their start are in the
time. Where two processes share a core with others, the ratio says what the others left.
"""

import argparse
import os
import shutil
import tempfile
import time
from pathlib import Path

from instrument.config import bench_of_tables
from instrument.plan import MotionPlan, Plan
from instrument.series import analyse_series, recordings_in
from instrument.session import Instrument
from instrument.workers import Where

_SPEEDS_MM_S = (4.0, 8.0, 12.0, 16.0)


def record(folder: Path, recordings: int, frames: int) -> None:
    """Record four runs, and copy them until there are enough."""
    tables = {name: {"driver": "simulated"} for name in ("modulator", "counter", "stage")}
    scene = {"noise": {"kind": "pixel", "sigma": 0.1, "seed": 1}}
    with Instrument.from_config(bench_of_tables({**tables, "scene": scene}, "many")) as bench:
        for k, speed in enumerate(_SPEEDS_MM_S):
            motion = MotionPlan(velocity_mm_s=speed)
            bench.run(Plan(frames=frames, image_size=64, superpixel=4, motion=motion), folder / f"{k:04d}.h5")
    for k in range(len(_SPEEDS_MM_S), recordings):
        shutil.copyfile(folder / f"{k % len(_SPEEDS_MM_S):04d}.h5", folder / f"{k:04d}.h5")


def took_s(folder: Path, processes: int) -> tuple[float, float]:
    """Analyse a folder anew; give seconds of the clock, and of all processors for this program."""
    clock, used = time.perf_counter(), sum(os.times()[:4])
    series = analyse_series(recordings_in([folder]), where=Where(processes=processes), again=True)
    if series.failures:
        raise SystemExit("\n".join(f"{path}: {failure.why}" for path, failure in series.failures.items()))
    return time.perf_counter() - clock, sum(os.times()[:4]) - used


def main() -> None:
    """Print times and ratio."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--recordings", type=int, default=100)
    parser.add_argument("--frames", type=int, default=1666, help="of each")
    arguments = parser.parse_args()
    with tempfile.TemporaryDirectory(prefix="kinopix-many-") as name:
        folder = Path(name)
        record(folder, arguments.recordings, arguments.frames)
        took_s(folder / "0000.h5", 1)  # libraries and code warm
        found: dict[int, tuple[float, float]] = {}
        for processes in (1, 2):
            wall_s, cpu_s = found[processes] = took_s(folder, processes)
            load = os.getloadavg()[0]
            print(
                f"{processes} process{'es' * (processes > 1)}: {wall_s:6.1f} s, {cpu_s:6.1f} s of CPU, load {load:.1f}",
                flush=True,
            )
    ratio, free = found[1][0] / found[2][0], found[1][1] / (found[2][1] / 2)
    print(
        f"{arguments.recordings} recordings on two processes: {ratio:.2f} times the speed of one; by processor time, "
        f"which counts as if each had a core to itself, {free:.2f} times"
    )


if __name__ == "__main__":
    main()
