"""What random faults of the sync line and wild counts do to a run: ``python -m benchmarks.slips [--short] [--runs 300]``.

Each run of the simulated bench has one fault, or three: a lost edge, a doubled one at any time within the picture, surplus edges
after the run, or a wild count of 0 or 3 to 1,000 times its value. It is recorded with edge times and without. A frame is silently
wrong if it is still valid when the analysis begins, and a value of it is beyond 6 standard deviations of what it is without noise
and faults. The second table multiplies one value of a run of 1,666 frames by 100 at 16 places, and prints the error of the path.
"""

import argparse
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import numpy as np

from instrument import Plan, Recording, analyse, open_recording, simulate
from instrument.config import bench_of_tables
from instrument.measurement import Measurement
from instrument.session import Instrument
from protocols import Floats, KinopixError

PEAK: Final = 250.0
PLAN: Final = Plan(frames=150, image_size=64)
SPEED_PX_S: Final = 250.0
SIGMAS: Final = 6.0
LOST_SHARE: Final = 0.1  # of the wild counts


@dataclass(frozen=True)
class Outcome:
    """What became of one run."""

    kept: int
    """Frames that are valid."""

    wrong: int
    """Of those, frames with a value that is far off."""

    told: bool
    """Whether anything was said: an error, a verdict that is not good, or a finding."""


def scene(seed: int, faults: list[dict[str, Any]]) -> dict[str, Any]:
    """An object that moves along the diagonal, seen by photons."""
    noise = {"kind": "poisson", "peak_counts": PEAK, "seed": seed}
    return {"object": "letter-B", "start_px": [22.0, 22.0], "noise": noise, "faults": faults}


@cache
def expected(folder: Path) -> Floats:
    """Counts without noise and without faults."""
    exact = recorded(folder, {**scene(0, []), "noise": {"kind": "none"}}, edge_times=True)
    if exact is None:
        raise RuntimeError("a run without faults broke")
    return np.asarray(exact.values * (PEAK / exact.values[0, 4:].sum()), np.float64)


def recorded(folder: Path, table: dict[str, Any], *, edge_times: bool) -> Recording | None:
    """Record one run; of one that breaks, what is kept of it."""
    motion = folder / "motion.csv"
    if not motion.exists():
        times_s = np.linspace(0, 2 * PLAN.run_time_s, 500)
        motion.write_text(
            "t_s,x_px,y_px\n" + "".join(f"{t:.7f},{SPEED_PX_S * t:.6f},{SPEED_PX_S * t:.6f}\n" for t in times_s)
        )
    devices: dict[str, Any] = {role: {"driver": "simulated"} for role in ("modulator", "counter", "stage")}
    devices["counter"]["edge_times"] = edge_times
    path = folder / "run.h5"
    path.unlink(missing_ok=True)
    config = bench_of_tables({**devices, "scene": {**table, "trajectory": str(motion)}}, "benchmarks.slips")
    try:
        with Instrument.from_config(config) as bench:
            return bench.run(PLAN, path)
    except KinopixError:
        return open_recording(path) if path.exists() else None


def random_faults(rng: np.random.Generator, count: int) -> tuple[list[dict[str, Any]], list[tuple[int, int, float]]]:
    """Draw faults of the sync line, and wild counts as frame, column and factor."""
    faults: list[dict[str, Any]] = []
    spikes: list[tuple[int, int, float]] = []
    kinds: tuple[str, ...] = ("drop-edge", "double-edge", "surplus-edges", "spike")
    for kind in [kinds[int(index)] for index in rng.integers(4, size=count)]:
        if kind == "spike":
            factor = 0.0 if rng.random() < LOST_SHARE else float(3 * np.exp(rng.uniform(0.0, 5.8)))
            spikes.append((int(rng.integers(PLAN.frames)), int(rng.integers(0, 6)), factor))
        elif kind == "surplus-edges":
            faults.append({"kind": kind, "edges": int(rng.integers(1, 4))})
        else:
            picture = int(rng.integers(PLAN.patterns + 1))
            echo = {"after_s": float(rng.uniform(1e-6, 4.9e-5))} if kind == "double-edge" else {}
            faults.append({"kind": kind, "picture": picture, **echo})
    return faults, spikes


def outcome(folder: Path, seed: int, count: int, *, edge_times: bool) -> tuple[Outcome, str]:
    """Record one run with random faults, and compare what is still valid with what is expected."""
    faults, spikes = random_faults(np.random.default_rng([seed, count]), count)
    what = f"seed {seed}: {faults} {spikes}"
    truth = expected(folder)
    recording = recorded(folder, scene(seed, faults), edge_times=edge_times)
    if recording is None:
        return Outcome(0, 0, told=True), what
    values = recording.values.copy()
    for frame, column, factor in spikes:
        if frame < len(values):
            values[frame, column] = np.round(factor * values[frame, column])
    told = recording.timing is None or recording.timing.verdict != "good"
    measured = Measurement.of(replace(recording, values=values))
    off = np.abs(measured.values - truth[: len(measured)]) > SIGMAS * np.sqrt(truth[: len(measured)] + SIGMAS)
    wrong = measured.valid & off.any(axis=1)
    told = told or bool(measured.findings)
    return Outcome(int(measured.valid.sum()), int(wrong.sum()), told), what


def table_of_faults(runs: int) -> None:
    """Print one line for each number of faults, with and without edge times."""
    print(
        "| faults a run | edge times | runs | with wrong frames | of them silent | wrong frames | told | frames kept (median) |"
    )
    print("|---|---|---|---|---|---|---|---|")
    with TemporaryDirectory() as name:
        folder = Path(name)
        for count in (1, 3):
            for edge_times in (True, False):
                found = [outcome(folder, seed, count, edge_times=edge_times) for seed in range(runs)]
                results = [result for result, _ in found]
                bad = [(result, what) for result, what in found if result.wrong]
                silent = sum(not result.told for result, _ in bad)
                wrong, told = sum(r.wrong for r in results), sum(r.told for r in results)
                kept = float(np.median([r.kept for r in results]))
                yes = "yes" if edge_times else "no"
                print(f"| {count} | {yes} | {runs} | {len(bad)} | {silent} | {wrong} | {told} | {kept:g} |", flush=True)
                for result, what in bad[:5]:
                    print(f"  {result.wrong} of {result.kept} frames, told: {result.told}; {what}", flush=True)


def table_of_wild_counts(places: int) -> None:
    """Print the error of the path with one value of a run times 100."""
    frames = 1666
    run_s = frames * 6 * 50e-6
    noise = {"kind": "poisson", "peak_counts": PEAK, "seed": 1}
    clean = simulate(
        Plan(frames=frames),
        {"object": "letter-B", "start_px": [30.0, 30.0], "noise": noise},
        path=lambda time_s: np.stack([60 * time_s / run_s, 50 * time_s / run_s], axis=1),
    )
    print(f"one value times 100: MSE {analyse(clean).figures.displacement_mse_px2:.5f} px^2 without")
    rng = np.random.default_rng(1)
    for k in range(places):
        frame, column = int(rng.integers(frames)), k % 6
        values = clean.values.copy()
        values[frame, column] *= 100
        figures = analyse(replace(clean, values=values)).figures
        print(
            f"  frame {frame} column {column}: {figures.displacement_mse_px2:.5f} px^2; {'; '.join(figures.found)}",
            flush=True,
        )


def main() -> None:
    """Print both tables."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=300, help="runs of each line")
    parser.add_argument("--short", action="store_true", help="20 runs of each line, and 2 places")
    arguments = parser.parse_args()
    table_of_faults(20 if arguments.short else arguments.runs)
    table_of_wild_counts(2 if arguments.short else 16)


if __name__ == "__main__":
    main()
