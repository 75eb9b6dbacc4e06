"""Displacement and image after joint refinement, on the simulation of the paper: 128 x 128, 1,666 frames, noise 0.1 a pixel.

``python -m benchmarks.reconstruction [--seeds 5] [--only TITLE | --methods]``, from the repository's root. Times are those of
this machine, now.
"""

import argparse
import time
from dataclasses import dataclass
from typing import Literal

import numpy as np

from benchmarks.limits import Limits, cramer_rao
from benchmarks.scenes import FRAMES, SIZE, Path2D, arc, diagonal, recorded, scene
from instrument.choices import Extent
from instrument.joint import refine
from instrument.numerics import displacement_mse, offset_free_mse, psnr, ssim_global, ssim_local
from instrument.plan import Plan
from instrument.reconstruction import Method, reconstruct
from instrument.recording import Recording
from instrument.schemes import FourierHadamardSettings
from instrument.tracking import track
from protocols import Floats


def row(recording: Recording, *, region: Extent) -> list[float]:
    """Figures of one run."""
    truth = recording.truth
    if truth is None:
        return []
    gain = recording.photon_counts
    started = time.perf_counter()
    tracked = track(recording)
    refined = refine(recording, tracked, region=region)
    took = time.perf_counter() - started
    found, image = refined.trajectory, refined.image.image
    started = time.perf_counter()
    best = reconstruct(recording, truth.displacement_px, region=region)
    best_took = time.perf_counter() - started
    error = np.abs(found.displacement_px - truth.displacement_px)[1:]
    return [
        displacement_mse(tracked.displacement_px, truth.displacement_px),
        displacement_mse(found.displacement_px, truth.displacement_px),
        offset_free_mse(found.displacement_px, truth.displacement_px),
        float(np.mean(error < 1.96 * found.sigma_px[1:])),
        float(np.sqrt(np.mean((error / found.sigma_px[1:]) ** 2))),
        psnr(image, truth.image, fit_gain=gain),
        psnr(best.image, truth.image, fit_gain=gain),
        ssim_global(image, truth.image, fit_gain=gain),
        ssim_local(image, truth.image, fit_gain=gain),
        refined.image.misfit,
        took,
        best_took,
        best.iterations,
    ]


@dataclass(frozen=True)
class Case:
    """One line of the table: what differs from a "B" on 1,666 frames, noise ``pixel`` 0.1, solved for in the region."""

    title: str
    name: str = "letter-B"
    counts: float = 0.0
    """Mean counts of a half-lit pattern; an all-on pattern has twice as many. 0 takes noise ``pixel``."""
    planned: int = FRAMES
    """Frames of the plan: the whole way is gone in them, so that fewer are a faster motion."""
    used: int = FRAMES
    """Of those, the first so many are analysed."""
    order: Literal["tv", "hyperbolic"] = "tv"
    region: Extent = "inside"

    @property
    def plan(self) -> Plan:
        """What is shown."""
        scheme = FourierHadamardSettings(hadamard_order=self.order)
        return Plan(frames=self.planned, image_size=SIZE, scheme=scheme)

    def run(self, path: Path2D, seed: int) -> Recording:
        """Record it."""
        plan, slower = self.plan, FRAMES / self.planned
        peak = 2 * self.counts if self.counts else None
        whole = recorded(plan, scene(self.name), lambda t: path(slower * t), sigma=0.1, peak_counts=peak, seed=seed)
        return whole.first(self.used)

    def mean(self, path: Path2D, seeds: int) -> Floats:
        """Mean figures over seeds."""
        rows = [row(self.run(path, seed), region=self.region) for seed in range(seeds)]
        mean: Floats = np.mean(rows, axis=0)
        return mean

    def limits(self, path: Path2D, degree: int) -> Limits:
        """What no tracker can be better than."""
        plan, slower = (
            Plan(frames=self.planned, image_size=SIZE, scheme=FourierHadamardSettings(hadamard_order=self.order)),
            FRAMES / self.planned,
        )
        return cramer_rao(
            plan,
            scene(self.name),
            lambda t: path(slower * t),
            frames=min(self.planned, self.used),
            degree=degree,
            sigma=0.1,
            peak_counts=2 * self.counts if self.counts else None,
        )


MOTIONS: tuple[tuple[str, Path2D, int], ...] = (("I", arc, 4), ("II", diagonal, 2))
"""Name, path, and the degree of the polynomial that it is: to 0.01 px, and exactly."""
CASES = (
    Case("B"),
    Case("plane", "plane"),
    Case("bars", "bars"),
    Case("bars, hyperbolic", "bars", order="hyperbolic"),
    Case("B, full field", region="field"),
    Case("B, first 333 of 1666", used=333),
    Case("B, plan of 333", planned=333),
    Case("B, plan of 333, hyp.", planned=333, order="hyperbolic"),
    Case("B, plan of 666", planned=666),
    *(Case(f"B, {counts} counts", counts=counts) for counts in (25, 50, 100, 125, 250, 1000, 4000)),
)


def compare_methods(seeds: int) -> None:
    """Print PSNR with the true motion, edges freed against a Bregman step, each at three strengths."""
    tried: tuple[tuple[Method, float], ...] = (
        *(("tv", strength) for strength in (2.0, 3.0, 4.0)),
        *(("tv-bregman", strength) for strength in (2.0, 4.0, 5.0, 6.0)),
    )
    print("PSNR, true motion, region" + " ".join(f"{method:>10s} {strength:g}" for method, strength in tried))
    for case in (Case("B"), Case("plane", "plane"), Case("bars", "bars"), Case("B, 50 counts", counts=50)):
        for motion, path, _ in MOTIONS:
            figures = np.zeros(len(tried))
            for seed in range(seeds):
                recording = case.run(path, seed)
                if recording.truth is None:
                    continue
                truth, gain = recording.truth, recording.photon_counts
                found = [reconstruct(recording, truth.displacement_px, m, strength=s).image for m, s in tried]
                figures += [psnr(image, truth.image, fit_gain=gain) / seeds for image in found]
            print(f"{case.title:22s} {motion:2s}" + " ".join(f"{figure:12.2f}" for figure in figures), flush=True)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=5)
    parser.add_argument("--only", default="", help="cases whose title contains this")
    parser.add_argument("--methods", action="store_true", help="compare edges freed with a Bregman step instead")
    arguments = parser.parse_args()
    seeds: int = arguments.seeds
    if arguments.methods:
        compare_methods(seeds)
        return
    only: str = arguments.only
    heads = (
        "CR frame",
        "CR path",
        "trackMSE",
        "MSE",
        "off-free",
        "covered",
        "err/sig",
        "PSNR",
        "true",
        "SSIMglob",
        "SSIMloc",
        "misfit",
        "all s",
    )
    print(
        "'CR frame', 'CR path': Cramer-Rao limits of the displacement's MSE, of a frame alone and of the path; see limits.py."
    )
    print(
        "MSE in px^2. 'true': PSNR of reconstruct() given the true motion, its time and iterations. Counts: mean of a half-lit"
    )
    print(
        "pattern; of an all-on pattern they are twice as many, so that '50 counts' in that reading is the line of 25."
    )
    print(" " * 26 + " ".join(f"{head:>8s}" for head in (*heads, "true s", "iter.")))
    for case in CASES:
        if only not in case.title:
            continue
        for motion, path, degree in MOTIONS:
            limits = case.limits(path, degree)
            figures = [limits.frame_px2, limits.path_px2, *case.mean(path, seeds).tolist()]
            print(f"{case.title:22s} {motion:2s} " + " ".join(f"{value:8.4f}" for value in figures), flush=True)
    for motion, path, _ in MOTIONS:
        still = recorded(Plan(frames=FRAMES, image_size=SIZE), scene("letter-B"), path)
        if still.truth is not None and not only:
            started = time.perf_counter()
            exact = reconstruct(still, still.truth.displacement_px)
            took = time.perf_counter() - started
            figure = psnr(exact.image, still.truth.image)
            print(f"without noise, true motion {motion}: {figure:.1f} dB, {exact.iterations} iterations, {took:.2f} s")


if __name__ == "__main__":
    main()
