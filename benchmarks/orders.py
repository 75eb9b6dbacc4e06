"""Orders of the Hadamard patterns on objects of different fineness: ``python -m benchmarks.orders [--seeds 2] [--sigma 0.1]``.

128 x 128 pixels, noise ``pixel``, motion II, 1,666 frames of the six-pattern scheme in each order. The path is the true one, so
that the order alone decides. Every seed has its own noise and its own place of the object, between pixels.

A line an order: PSNR of the image (dB, least total variation) for a plane, a "B", and three-bar groups ("bars", the finest 1.5
pixels wide), each from all frames and from the first quarter of them; then the seconds that the image of the "B" took.
"""

import argparse
import time
from typing import get_args

import numpy as np

from benchmarks.scenes import FRAMES, MOTIONS, placed, recorded
from benchmarks.schemes import PLACES_PX, stretched
from instrument.numerics import psnr
from instrument.patterns import HadamardOrder
from instrument.plan import Plan
from instrument.reconstruction import reconstruct

OBJECTS = ("plane", "letter-B", "bars")


def one_run(order: str, name: str, seed: int, sigma: float) -> tuple[float, float, float]:
    """PSNR from all frames and from the first quarter, and the time that the image took."""
    plan = Plan.model_validate({"frames": FRAMES, "scheme": {"name": "fourier-hadamard", "hadamard_order": order}})
    place_px = np.random.default_rng(seed).random(2) * PLACES_PX
    path = stretched(MOTIONS["II"], plan.run_time_s, place_px)
    recording = recorded(plan, placed(name, 5, 5), path, sigma=sigma, seed=seed)
    truth = recording.truth
    assert truth is not None  # noqa: S101  (simulated)
    started_s = time.perf_counter()
    image = reconstruct(recording, truth.displacement_px).image
    took_s = time.perf_counter() - started_s
    some = recording.first(FRAMES // 4)
    early = reconstruct(some, truth.displacement_px[: FRAMES // 4]).image
    return psnr(image, truth.image), psnr(early, truth.image), took_s


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=2)
    parser.add_argument("--sigma", type=float, default=0.1)
    options = parser.parse_args()
    print(f"{'order':14}" + "".join(f"{name:>11}{'quarter':>9}" for name in OBJECTS) + f"{'s':>7}")
    for order in get_args(HadamardOrder):
        cells, took_s = "", 0.0
        for name in OBJECTS:
            runs = [one_run(order, name, seed, options.sigma) for seed in range(options.seeds)]
            whole, early, seconds = np.mean(runs, axis=0).tolist()
            cells += f"{whole:11.1f}{early:9.1f}"
            took_s = seconds if name == "letter-B" else took_s
        print(f"{order:14}{cells}{took_s:7.2f}", flush=True)


if __name__ == "__main__":
    main()
