"""Runs of an object, a place, a direction and a bench drawn at random, for the benchmarks of what an analysis tells of them.

Each has 1,666 frames and 128 x 128 pixels, no edge times, and a travel of 10 to 60 px. Benches are ideal, or have mirrors that
leak, edges that lose light, ambient light, a lamp that flickers and inverted mirrors, each by chance.
"""

import argparse
from typing import Any, Final

import numpy as np

from instrument import Figures, Plan, Recording, simulate
from protocols import Floats

FRAMES: Final = 1666
OBJECTS: Final = ("letter-B", "letter-B", "plane", "bars", "ring")


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
    return with_its_light(rng, counts, ideal=ideal)[0]


def with_its_light(
    rng: np.random.Generator, counts: float, *, ideal: bool, lit: bool = False
) -> tuple[Recording, Floats | None, str]:
    """Record one run; with the values that it has without noise, in some unit, if asked for, and the object's name."""
    plan = Plan(frames=FRAMES)
    angle = np.pi / 4 if rng.random() < 0.4 else float(rng.uniform(0, np.pi / 2))
    speed_px_s = float(rng.uniform(10, 60)) / plan.run_time_s * np.array([np.cos(angle), np.sin(angle)])
    scene: dict[str, Any] = {
        "object": str(rng.choice(OBJECTS)),
        "start_px": rng.uniform(28, 40, 2).tolist(),
        "noise": {"kind": "poisson", "peak_counts": float(counts), "seed": int(rng.integers(1 << 30))},
        **({} if ideal else bench(rng)),
    }

    def path(time_s: Floats) -> Floats:
        return np.multiply.outer(time_s, speed_px_s)

    light = simulate(plan, {**scene, "noise": {"kind": "none"}}, path=path).values if lit else None
    return simulate(plan, scene, path=path), light, scene["object"]


def against_truth(figures: Figures) -> tuple[float, float]:
    """Give the mean squared error of the displacement in px^2, and the PSNR of the image in dB."""
    assert figures.displacement_mse_px2 is not None  # noqa: S101  (a simulated run has a truth)
    assert figures.psnr_db is not None  # noqa: S101
    return figures.displacement_mse_px2, figures.psnr_db


def options(about: str | None) -> argparse.ArgumentParser:
    """Give the options of such a benchmark: how many runs, and which."""
    parser = argparse.ArgumentParser(description=about, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--runs", type=int, default=50, help="runs of each line")
    parser.add_argument("--first", type=int, default=0, help="first seed")
    return parser


def seeds(arguments: argparse.Namespace) -> range:
    """Give the seeds of the runs that were asked for."""
    first: int = arguments.first
    return range(first, first + arguments.runs)
