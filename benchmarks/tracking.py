"""Displacement error, coverage and time of every tracker on every motion: ``python -m benchmarks.tracking --seeds 5``.

128 x 128 pixels, 1,666 frames, "B" 36 px high, noise ``pixel`` of 0.1, one line a motion and method.
"""

import argparse
import time
from collections.abc import Callable
from typing import TypeAlias

import numpy as np

from benchmarks.scenes import FRAMES, MOTIONS, letter_b, recorded
from instrument.plan import Plan
from instrument.recording import Recording
from instrument.tracking import StreamingTracker, Trajectory, track
from protocols import Floats

Method: TypeAlias = Callable[[Recording], Trajectory | Floats]


def _streaming() -> Method:
    """Prepared before the run, as it would be; the time is that of one block."""
    tracker = StreamingTracker(Plan(frames=FRAMES))
    return lambda recording: tracker.push(recording.values)


METHODS: dict[str, Callable[[], Method]] = {
    "per-frame": lambda: lambda recording: track(recording, "per-frame"),
    "smooth": lambda: track,
    "streaming": _streaming,
}


def _judge(prepare: Callable[[], Method], recordings: list[Recording]) -> str:
    figures: list[tuple[float, float, float, float]] = []
    for recording in recordings:
        method = prepare()
        start = time.perf_counter()
        found = method(recording)
        spent = time.perf_counter() - start
        truth = np.zeros(0) if recording.truth is None else recording.truth.displacement_px
        error = np.asarray(found, np.float64) - truth
        covered = np.nan
        if isinstance(found, Trajectory):
            covered = float((np.abs(error[1:]) <= 1.96 * found.sigma_px[1:]).mean())
        figures.append((float((error**2).mean()), float(error.var(axis=0).mean()), covered, spent))
    mse, free, covered, _ = np.mean(figures, axis=0)
    spent = np.median([figure[3] for figure in figures])
    return f"{mse:10.4f} {free:12.4f} {100 * covered:9.1f} {1e3 * spent:9.1f} {1e6 * spent / FRAMES:11.2f}"


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=5, help="runs a line, each with its own noise and starting place")
    seeds = parser.parse_args().seeds
    print(
        f"{'motion':14} {'method':10} {'MSE px^2':>10} {'offset-free':>12} {'cover %':>9} {'ms':>9} {'us a frame':>11}"
    )
    for motion, path in MOTIONS.items():
        recordings: list[Recording] = []
        for seed in range(seeds):
            top, left = np.random.default_rng(seed).integers(4, 18, 2).tolist()
            recordings.append(recorded(Plan(frames=FRAMES), letter_b(top, left), path, sigma=0.1, seed=seed))
        for name, prepare in METHODS.items():
            print(f"{motion:14} {name:10} {_judge(prepare, recordings)}")


if __name__ == "__main__":
    main()
