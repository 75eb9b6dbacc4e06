"""Objects that turn: ``python -m benchmarks.turning [--seeds 3] [--sigma 0.1] [--frames 1666]``.

128 x 128 pixels, a "B" 36 px high that goes 35 px across and 30 px down and turns at a constant rate, noise ``pixel``. Every seed
has its own noise and its own place, between pixels.

A line a turn (degrees in the run): error of the angle, rms over frames, from the moments alone and after joint refinement; the
median of its stated uncertainty; PSNR and misfit of the image; time.
"""

import argparse
import time
from typing import Final

import numpy as np

from benchmarks.scenes import placed
from instrument import Plan, simulate
from instrument.joint import refine_turn
from instrument.measurement import first_light
from instrument.numerics import psnr
from instrument.tracking import track
from protocols import Floats

TURNS_DEG: Final = (0.0, 20.0, 90.0, 180.0, 360.0)


def one_run(turn_deg: float, seed: int, sigma: float, frames: int, upsampling: int) -> list[float]:
    """Figures of one run."""
    plan = Plan.model_validate(
        {"frames": frames, "superpixel": 4, "scheme": {"name": "moment-rotation", "upsampling": upsampling}}
    )
    start_px = 15 + 10 * np.random.default_rng(seed).random(2)

    def path(time_s: Floats) -> Floats:
        way: Floats = start_px + np.outer(time_s / plan.run_time_s, [35.0, 30.0])
        return way

    noise = {"kind": "pixel", "sigma": sigma, "seed": seed} if sigma else {"kind": "none"}
    recording = simulate(
        plan, {"noise": noise, "object_turn_deg": turn_deg}, image=placed("letter-B", 10, 10), path=path
    )
    measurement = first_light(recording)
    assert recording.truth is not None  # noqa: S101  (simulated)
    truth_deg = turn_deg * np.arange(frames) / frames
    tracked = track(measurement)
    started_s = time.perf_counter()
    found = refine_turn(measurement, tracked)
    took_s = time.perf_counter() - started_s
    angles = tracked.angle_deg, found.trajectory.angle_deg
    errors = [float(np.sqrt(np.mean((angle - truth_deg) ** 2))) for angle in angles if angle is not None]
    sigma_deg = found.trajectory.angle_sigma_deg
    assert sigma_deg is not None  # noqa: S101  (the scheme sees the angle)
    image_db = psnr(found.image.image, recording.truth.image)
    return [*errors, float(np.median(sigma_deg)), image_db, found.image.misfit, took_s]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--sigma", type=float, default=0.1)
    parser.add_argument("--frames", type=int, default=1666)
    parser.add_argument("--upsampling", type=int, default=2)
    parser.add_argument("--turns", type=float, nargs="*", default=TURNS_DEG)
    options = parser.parse_args()
    print(f"{'turn':>6}{'moments':>10}{'refined':>10}{'stated':>9}{'PSNR':>8}{'misfit':>8}{'s':>7}")
    for turn_deg in options.turns:
        runs = [
            one_run(turn_deg, seed, options.sigma, options.frames, options.upsampling) for seed in range(options.seeds)
        ]
        moments, refined, stated, image_db, misfit, took_s = np.mean(runs, axis=0).tolist()
        cells = f"{moments:10.2f}{refined:10.2f}{stated:9.2f}{image_db:8.1f}{misfit:8.2f}{took_s:7.1f}"
        print(f"{turn_deg:6.0f}{cells}", flush=True)


if __name__ == "__main__":
    main()
