"""The whole analysis of large fields, its time and memory, and what they grow with: ``python -m benchmarks.large_fields``.

Each run is computed from the formulas (``by_formula``) and analysed with every default in a process of its own, whose memory is
its resident memory at most. A "B" of 9/32 of the field goes 66/128 of the field along the diagonal; noise of 0.1 on every pixel.
Products with the rows go to two cores where there are two. Beside the time that it took stands what it would take if both cores
were free: the processor time of the first thread, and half of that of the threads that share the products. ``--only 256x10000``
analyses one.
"""

import argparse
import json
import os
import resource
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from benchmarks.by_formula import by_formula
from benchmarks.growth import exponent
from benchmarks.scenes import placed
from instrument.analysis import analyse
from instrument.plan import Plan
from instrument.recording import Recording
from protocols import Floats, Truth

FIELDS = ((128, 10_000), (256, 10_000), (512, 10_000), (256, 20_000), (256, 40_000), (256, 65_536), (512, 40_000))


@dataclass(frozen=True)
class Cost:
    """Of one analysis."""

    size: int
    frames: int
    wall_s: float
    cpu_s: float
    own_s: float
    """Processor time of the first thread."""
    memory_mb: float
    psnr_db: float
    misfit: float

    @property
    def free_s(self) -> float:
        """Time on two cores that nobody else uses."""
        return self.own_s + (self.cpu_s - self.own_s) / 2


def run(size: int, frames: int) -> Recording:
    """Compute a run of motion II over the field."""
    corner_px = 22 * size // 128
    image = placed("letter-B", corner_px, corner_px, height_px=36 * size / 128, size=size)
    plan = Plan(frames=frames, image_size=size)

    def path(time_s: Floats) -> Floats:
        part = time_s / plan.run_time_s
        way: Floats = (66 * size / 128 / np.sqrt(2) * (0.77 * part + 0.23 * part**2))[:, None] * np.ones(2)
        return way

    return by_formula(plan, image, path)


def analysed(values: Path, size: int, frames: int) -> Cost:
    """Analyse a run that another process has computed, and take note of time and memory."""
    with np.load(values) as kept:
        recording = Recording(
            plan=Plan(frames=frames, image_size=size),
            values=kept["values"],
            frame_valid=np.ones(frames, np.bool_),
            picture_time_s=50e-6,
            truth=Truth(displacement_px=kept["displacement_px"], image=kept["image"]),
        )
    clocks = (time.perf_counter, time.process_time, time.thread_time)
    began = [clock() for clock in clocks]
    figures = analyse(recording).figures
    wall_s, cpu_s, own_s = (clock() - at for clock, at in zip(clocks, began, strict=True))
    memory_mb = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6
    return Cost(size, frames, wall_s, cpu_s, own_s, memory_mb, figures.psnr_db or 0.0, figures.misfit or 0.0)


def in_its_own_process(size: int, frames: int) -> Cost:
    """Compute a run here, and analyse it there."""
    with tempfile.TemporaryDirectory(prefix="kinopix-large-") as folder:
        values = Path(folder) / "values.npz"
        recording = run(size, frames)
        truth = recording.truth
        assert truth is not None  # noqa: S101 - simulated
        np.savez(values, values=recording.values, displacement_px=truth.displacement_px, image=truth.image)
        del recording, truth
        words = [sys.executable, "-m", "benchmarks.large_fields", "--values", str(values), "--only", f"{size}x{frames}"]
        done = subprocess.run(words, check=True, capture_output=True, text=True)
    return Cost(**json.loads(done.stdout))


def main() -> None:
    """Print the table, and the exponents over rows and over pixels a side."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--only", help="one field and its rows, such as 256x10000")
    parser.add_argument("--values", type=Path, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    fields = FIELDS if arguments.only is None else [tuple(map(int, arguments.only.split("x")))]
    if arguments.values is not None:
        print(json.dumps(asdict(analysed(arguments.values, *fields[0]))))
        return
    print("| field | rows | s | s of CPU | s, both cores free | MB | PSNR, dB | misfit | load |")
    print("|---" * 9 + "|")
    costs: list[Cost] = []
    for size, frames in fields:
        c = in_its_own_process(size, frames)
        costs.append(c)
        print(
            f"| {size} x {size} | {frames} | {c.wall_s:.1f} | {c.cpu_s:.1f} | {c.free_s:.1f} | {c.memory_mb:.0f} "
            f"| {c.psnr_db:.1f} | {c.misfit:.2f} | {os.getloadavg()[0]:.1f} |",
            flush=True,
        )
    if len(costs) == 1:
        return
    print()
    for what, along, chosen in (
        ("rows, at 256 x 256", "frames", [c for c in costs if c.size == 256]),
        ("pixels a side, at 10,000 rows", "size", [c for c in costs if c.frames == 10_000]),
    ):
        steps = [getattr(c, along) for c in chosen]
        grow = {name: exponent(steps, [getattr(c, name) for c in chosen]) for name in ("cpu_s", "free_s", "memory_mb")}
        print(
            f"With {what}: processor time to the power {grow['cpu_s']:.2f}, time on two free cores {grow['free_s']:.2f}, "
            f"memory {grow['memory_mb']:.2f}"
        )


if __name__ == "__main__":
    main()
