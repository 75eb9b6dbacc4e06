"""Recordings of hours, analysed in windows: time and memory over their length: ``python -m benchmarks.long_recordings``.

Two recordings, a quarter of ``--patterns`` (10,000,000: 8 minutes at 20 kHz) and all of them, of a "B" that goes round in a field
of 32 x 32, computed from the formulas and written as a run writes them, with edge times. Each is tracked over all frames, with an
image of its last window, by a process of its own, whose memory is its resident memory at most.
"""

import argparse
import json
import resource
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Final

import numpy as np

from benchmarks.by_formula import by_formula
from benchmarks.scenes import placed
from instrument.analysis import analyse_in_windows
from instrument.plan import Plan
from instrument.storage import RecordingWriter
from instrument.tracking import windows_of
from protocols import Floats, Truth

_SIZE: Final = 32
_ROUND: Final = 20 * _SIZE**2
"""Frames in which the object goes round once: whole cycles of the patterns."""


def write(path: Path, frames: int, window_frames: int) -> None:
    """Write a recording, one round of the object after the other, each with noise of its own."""
    image, plan = placed("letter-B", 10, 8, height_px=9, size=_SIZE), Plan(frames=_ROUND, image_size=_SIZE)

    def path_px(time_s: Floats) -> Floats:
        angle = 2 * np.pi * time_s / plan.run_time_s
        return np.stack([5 * (1 - np.cos(angle)), 4 * np.sin(angle)], axis=1)

    one, rng = by_formula(plan, image, path_px, sigma=0.0), np.random.default_rng(0)
    assert one.truth is not None  # noqa: S101 - simulated
    whole = Plan(frames=frames, image_size=_SIZE)
    with RecordingWriter(path, whole, picture_time_s=50e-6, with_truth=True) as writer:
        for first in range(0, frames, _ROUND):
            count = min(_ROUND, frames - first)
            values = one.values[:count] + rng.normal(size=(count, 6)) * 0.1 * _SIZE / np.sqrt(2)
            edges = (6 * first + np.arange(values.size, dtype=np.float64)) * 50e-6
            writer.append(np.asarray(values.ravel(), np.float64), np.asarray(edges, np.float64))
        places = np.tile(one.truth.displacement_px, (-(-frames // _ROUND), 1))[:frames]
        writer.finish(truth=Truth(displacement_px=places, image=image))
    print(f"{path.stat().st_size / 1e6:.0f} MB, {len(windows_of(frames, window_frames, _SIZE**2))} windows", flush=True)


def analyse(path: Path, window_frames: int, last: int) -> None:
    """Analyse a recording here, and print what it cost."""
    used_s, clock = time.process_time(), time.perf_counter()
    done = analyse_in_windows(path, window_frames=window_frames, images=[last])
    print(
        json.dumps(
            {
                "s": time.perf_counter() - clock,
                "cpu": time.process_time() - used_s,
                "mb": resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e6,
                "mse": done.figures.displacement_mse_px2,
                "sigma": done.figures.sigma_px,
                "misfit": done.figures.misfit,
            }
        )
    )


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--patterns", type=int, default=10_000_000, help="of the longer recording")
    parser.add_argument("--window", type=int, default=50_000, help="frames of a window")
    parser.add_argument("--path", type=Path, help=argparse.SUPPRESS)
    parser.add_argument("--last", type=int, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.path is not None:
        analyse(arguments.path, arguments.window, arguments.last)
        return
    rows: list[str] = []
    for patterns in (arguments.patterns // 4, arguments.patterns):
        with tempfile.TemporaryDirectory(prefix="kinopix-long-") as folder:
            path, frames = Path(folder) / "run.h5", patterns // 6
            write(path, frames, arguments.window)
            last = len(windows_of(frames, arguments.window, _SIZE**2)) - 1
            words = ["--path", str(path), "--window", str(arguments.window), "--last", str(last)]
            command = [sys.executable, "-m", "benchmarks.long_recordings", *words]
            c = json.loads(subprocess.run(command, check=True, capture_output=True, text=True).stdout)
        costs = f"{c['s']:.0f} | {c['cpu']:.0f} | {c['mb']:.0f}"
        rows.append(f"| {6 * frames} | {costs} | {c['mse']:.5f} | {c['sigma']:.3f} | {c['misfit']:.2f} |")
    print("| patterns | s | s of CPU | MB | MSE, px^2 | stated, px | misfit of the last image |\n" + "|---" * 7 + "|")
    print("\n".join(rows))


if __name__ == "__main__":
    main()
