"""Displacement and image after joint refinement, on the simulation of the paper: 128 x 128, 1,666 frames, noise 0.1 a pixel.

``python -m benchmarks.reconstruction [--seeds 5]``, from the repository's root.
"""

import argparse
import time

import numpy as np

from instrument.analysis import refine
from instrument.analysis.metrics import displacement_mse, offset_free_mse, psnr, ssim_global, ssim_local
from instrument.plan import Plan
from instrument.reconstruction import reconstruct
from instrument.recording import Recording
from instrument.tracking import track
from protocols import Floats
from sim_backends.bench.objects import BUILT_INS
from tests.support.simulation import Path2D, simulate

FRAMES, SIZE = 1666, 128
RUN_S = FRAMES * 300e-6


def arc(time_s: Floats) -> Floats:
    """Motion I: a quarter of a circle of 45 px, 70.7 px of travel."""
    angle = np.pi / 2 * time_s / RUN_S
    way: Floats = 45 * np.stack([np.sin(angle), 1 - np.cos(angle)], axis=1)
    return way


def diagonal(time_s: Floats) -> Floats:
    """Motion II: 66 px along the diagonal, v0 t + a t^2 / 2 at the experiment's ratio."""
    part = time_s / RUN_S
    way: Floats = (66 / np.sqrt(2) * (0.77 * part + 0.23 * part**2))[:, None] * np.ones(2)
    return way


def scene(name: str) -> Floats:
    """A built-in object 36 px high, near the upper left corner."""
    drawing = BUILT_INS[name](36.0)
    finer = round(1 / drawing.cell_px)
    rows, columns = drawing.cells.shape
    field = np.zeros((SIZE * finer, SIZE * finer))
    field[22 * finer : 22 * finer + rows, 22 * finer : 22 * finer + columns] = drawing.cells
    image: Floats = field.reshape(SIZE, finer, SIZE, finer).mean(axis=(1, 3))
    return image


def row(recording: Recording, *, region: bool) -> list[float]:
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
    best = reconstruct(recording, truth.displacement_px, region=region).image
    error = np.abs(found.displacement_px - truth.displacement_px)[1:]
    return [
        displacement_mse(tracked.displacement_px, truth.displacement_px),
        displacement_mse(found.displacement_px, truth.displacement_px),
        offset_free_mse(found.displacement_px, truth.displacement_px),
        float(np.mean(error < 1.96 * found.sigma_px[1:])),
        psnr(image, truth.image, fit_gain=gain),
        psnr(best, truth.image, fit_gain=gain),
        ssim_global(image, truth.image, fit_gain=gain),
        ssim_local(image, truth.image, fit_gain=gain),
        refined.image.misfit,
        took,
    ]


def table(title: str, name: str, path: Path2D, seeds: int, *, frames: int = FRAMES, counts: float = 0.0) -> None:
    """Print one line: mean over seeds. ``counts`` is the mean of a half-lit pattern; 0 takes noise ``pixel`` 0.1."""
    rows: list[list[float]] = []
    for seed in range(seeds):
        plan = Plan(frames=FRAMES, image_size=SIZE)
        peak = 2 * counts if counts else None
        recording = simulate(plan, scene(name), path, sigma=0.1, peak_counts=peak, seed=seed).first(frames)
        rows.append(row(recording, region="full" not in title))
    mean = np.mean(rows, axis=0)
    print(f"{title:24s}" + " ".join(f"{value:8.4f}" for value in mean), flush=True)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=5)
    seeds: int = parser.parse_args().seeds
    heads = ("trackMSE", "MSE", "off-free", "covered", "PSNR", "PSNRtrue", "SSIMglob", "SSIMloc", "misfit", "s")
    print(" " * 24 + " ".join(f"{head:>8s}" for head in heads))
    motions: tuple[tuple[str, Path2D], ...] = (("I", arc), ("II", diagonal))
    for motion, path in motions:
        for name in ("letter-B", "plane", "bars"):
            table(f"{name} {motion}", name, path, seeds)
        table(f"letter-B {motion} full field", "letter-B", path, seeds)
        table(f"letter-B {motion} 333 frames", "letter-B", path, seeds, frames=333)
        for counts in (50, 100, 250):
            table(f"letter-B {motion} {counts} counts", "letter-B", path, seeds, counts=counts)
    still = simulate(Plan(frames=FRAMES, image_size=SIZE), scene("letter-B"), diagonal)
    if still.truth is not None:
        exact = psnr(reconstruct(still, still.truth.displacement_px).image, still.truth.image)
        print(f"without noise, true motion II: {exact:.1f} dB")


if __name__ == "__main__":
    main()
