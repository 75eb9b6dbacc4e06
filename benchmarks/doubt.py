"""Whether slips are told, placed and mended, and whether any is seen where there is none: ``python -m benchmarks.doubt``.

``[--runs 50] [--counts 50 280]``. Runs of 1,666 frames and 128 x 128 pixels without edge times, of an object, a place, a
direction and a travel of 10 to 60 px drawn at random. Benches are ideal, or have mirrors that leak, edges that lose light,
ambient light, a lamp that flickers and inverted mirrors, each by chance. Each run is looked at as it is, with all values one
pattern late and early, and with one value lost at a place drawn at random. "false" are runs without a fault in which a slip
was found or a frame masked for one; "placed" are those in which the lost value was told to 3 patterns; "kept" is the median
share of frames that stay valid; "wrong" are frames of all runs that are valid and hold a value of another pattern.
"""

import argparse
from dataclasses import dataclass, field
from typing import Any, Final

import numpy as np

from instrument import Plan, Recording, simulate
from instrument.measurement import Slips, in_step_again, slips_of_counts
from instrument.schemes import scheme_of
from protocols import Floats

FRAMES: Final = 1666
OBJECTS: Final = ("letter-B", "letter-B", "plane", "bars", "ring")
COUNTS: Final = (50, 100, 280, 1000, 4000)


def bench(rng: np.random.Generator) -> dict[str, Any]:
    """Draw the flaws of a bench."""
    flaws: dict[str, Any] = {
        "mirror_transition_s": float(rng.choice([2e-6, 4e-6, 12.5e-6])),
        "edge_loss": float(rng.choice([0.01, 0.02, 0.05, 0.1])),
        "ambient_level": float(rng.uniform(0, 0.3)),
        "led_flicker": float(rng.uniform(0, 0.2)),
        "mirrors_inverted": True,
    }
    return {name: value for name, value in flaws.items() if rng.random() < 0.5}


def recorded(rng: np.random.Generator, counts: float, *, ideal: bool) -> Recording:
    """Record one run."""
    plan = Plan(frames=FRAMES)
    angle = np.pi / 4 if rng.random() < 0.4 else float(rng.uniform(0, np.pi / 2))
    speed_px_s = float(rng.uniform(10, 60)) / plan.run_time_s * np.array([np.cos(angle), np.sin(angle)])
    scene: dict[str, Any] = {
        "object": str(rng.choice(OBJECTS)),
        "start_px": rng.uniform(28, 40, 2).tolist(),
        "noise": {"kind": "poisson", "peak_counts": float(counts), "seed": int(rng.integers(1 << 30))},
        **({} if ideal else bench(rng)),
    }
    return simulate(plan, scene, path=lambda time_s: np.multiply.outer(time_s, speed_px_s))


def slips_in(recording: Recording, values: Floats) -> Slips:
    """Look for slips as the screening does."""
    return slips_of_counts(values, recording.frame_valid, scheme_of(recording.plan), photon_counts=True)


@dataclass
class Line:
    """What was found at one light, on one kind of bench."""

    false: int = 0
    late: int = 0
    early: int = 0
    placed: int = 0
    kept: list[float] = field(default_factory=list[float])
    wrong: int = 0

    def add(self, recording: Recording, rng: np.random.Generator) -> None:
        """Look at one run."""
        values = recording.values
        found = slips_in(recording, values)
        self.false += found.any or not found.sure.all()
        for by in (1, -1):
            shifted = np.roll(values.ravel(), by).reshape(values.shape)
            found = slips_in(recording, shifted)
            right = [part.shift for part in found.segments] == [by]
            self.late += right and by > 0
            self.early += right and by < 0
            self._mended(found, shifted, values)
        lost = int(rng.integers(120, values.size - 120))
        short = np.append(np.delete(values.ravel(), lost), values[-1, -1]).reshape(values.shape)
        found = slips_in(recording, short)
        if [part.shift for part in found.segments] == [0, -1]:
            self.placed += abs(found.segments[1].first_pattern - lost) <= 3
        self._mended(found, short, values)

    def _mended(self, found: Slips, values: Floats, truth: Floats) -> None:
        """Count the frames that are kept, and those of them that are wrong."""
        mended = in_step_again(values, found) if found.any else np.where(found.sure[:, None], values, np.nan)
        valid = np.isfinite(mended).all(axis=1)
        self.wrong += int(np.count_nonzero((mended != truth).any(axis=1) & valid))
        if found.any:
            self.kept.append(float(valid.mean()))


def main() -> None:
    """Print one line for each light, of ideal benches and of others."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=50, help="runs of each line")
    parser.add_argument("--counts", type=float, nargs="+", default=COUNTS, help="counts of an all-on pattern")
    arguments = parser.parse_args()
    runs: int = arguments.runs
    print("| bench | counts | runs | false | late told | early told | lost one placed | kept | wrong frames |")
    print("|---|---|---|---|---|---|---|---|---|")
    for ideal in (True, False):
        for counts in arguments.counts:
            line = Line()
            for seed in range(runs):
                rng = np.random.default_rng([12, seed])
                line.add(recorded(rng, counts, ideal=ideal), rng)
            kept = float(np.median(line.kept)) if line.kept else float("nan")
            name = "ideal" if ideal else "with flaws"
            told = f"{line.false} | {line.late} | {line.early} | {line.placed}"
            print(
                f"| {name} | {counts:g} | {runs} | {told} | {kept:.3f} | {line.wrong} |",
                flush=True,
            )


if __name__ == "__main__":
    main()
