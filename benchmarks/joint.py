"""Displacement by every way of tracking, joint refinement among them: ``python -m benchmarks.joint [--seeds 5]``.

128 x 128 pixels; noise ``pixel`` of 0.1, or photons. A line a case: MSE, the same offset-free (px^2) and share of frames in the
95 % interval (%), for each frame by itself, smoothed, refined; then the image's PSNR with that motion and with the true one (dB),
and the seconds that refinement took. Every seed has its own noise and its own place of the object, as the error of dithering
depends on the place.
"""

import argparse
import os
import time
from dataclasses import dataclass

import numpy as np

from benchmarks.scenes import FRAMES, MOTIONS, Path2D, arc, diagonal, recorded, scene, wavy
from instrument.choices import Extent
from instrument.joint import refine
from instrument.numerics import displacement_mse, offset_free_mse, psnr
from instrument.plan import Plan
from instrument.reconstruction import reconstruct
from instrument.tracking import Trajectory, track
from protocols import Truth

PATHS: dict[str, Path2D] = {"arc": arc, "diagonal": diagonal, "wavy": wavy, **MOTIONS}


@dataclass(frozen=True)
class Case:
    """One line of the table."""

    motion: str
    scene: str = "letter-B"
    frames: int = FRAMES
    counts: float | None = None
    """Photons of a half-lit pattern; None for noise ``pixel``."""
    region: Extent = "inside"

    def __str__(self) -> str:
        """What differs from the first line."""
        light = "" if self.counts is None else f" {self.counts:g} counts"
        frames = "" if self.frames == FRAMES else f" {self.frames} frames"
        return f"{self.scene} {self.motion}{frames}{light}{'' if self.region == 'inside' else ' full field'}"


CASES = (
    *(Case(motion, scene) for scene in ("letter-B", "plane", "bars") for motion in ("arc", "diagonal", "I", "wavy")),
    *(Case(motion, frames=333) for motion in ("arc", "diagonal", "I", "wavy")),
    *(Case(motion, counts=counts) for counts in (50.0, 100.0, 250.0, 1000.0, 4000.0) for motion in ("arc", "diagonal")),
    *(Case(motion) for motion in list(MOTIONS)[2:]),
    Case("arc", region="field"),
)


def _figures(found: Trajectory, truth: Truth) -> list[float]:
    error = np.abs(found.displacement_px - truth.displacement_px)[1:]
    return [
        displacement_mse(found.displacement_px, truth.displacement_px),
        offset_free_mse(found.displacement_px, truth.displacement_px),
        100 * float(np.mean(error <= 1.96 * found.sigma_px[1:])),
    ]


def line(case: Case, seed: int) -> list[float]:
    """Figures of one run."""
    up, left = np.random.default_rng(seed).integers(0, 16, 2).tolist()
    image = np.roll(scene(case.scene), (-up, -left), axis=(0, 1))
    peak = None if case.counts is None else 2 * case.counts
    whole = recorded(Plan(frames=FRAMES), image, PATHS[case.motion], sigma=0.1, peak_counts=peak, seed=seed)
    recording = whole.first(case.frames)
    truth = recording.truth
    if truth is None:
        return []
    smooth = track(recording)
    started = time.perf_counter()
    refined = refine(recording, smooth, region=case.region)
    took_s = time.perf_counter() - started
    best = reconstruct(recording, truth.displacement_px, region=case.region)
    ways = (track(recording, "per-frame"), smooth, refined.trajectory)
    quality = [psnr(found.image, truth.image, fit_gain=peak is not None) for found in (refined.image, best)]
    return [figure for way in ways for figure in _figures(way, truth)] + [*quality, took_s]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--only", default="", help="cases whose name has this in it")
    options = parser.parse_args()
    print(f"{options.seeds} seeds, {os.cpu_count()} cores")
    print(f"{'':26}" + "".join(f"{name:^27}" for name in ("per-frame", "smooth", "joint")) + "  PSNR  true      s")
    for case in (case for case in CASES if options.only in str(case)):
        mean = np.mean([line(case, seed) for seed in range(options.seeds)], axis=0)
        ways = "".join(f"{mean[k]:10.4f} {mean[k + 1]:9.4f} {mean[k + 2]:6.1f}" for k in (0, 3, 6))
        print(f"{case!s:26}{ways} {mean[9]:6.1f} {mean[10]:5.1f} {mean[11]:6.2f}", flush=True)


if __name__ == "__main__":
    main()
