"""How fine a detail a moving object shows: contrast of three-bar groups, for several strengths of the smoothing.

``python -m benchmarks.bars [--seeds 3]``, from the repository's root. Four groups, upright and lying, at places drawn between
pixels; hyperbolic order, motion II, 1,666 frames. Contrast is (bars - gaps) / (bars + gaps) of the image's means over both.
"truth" is the object at twice the patterns' resolution, "1" and "2" are ``analyse`` on that grid; then comes grid 2 with the same
path and less smoothing.
"""

import argparse
from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.scenes import FRAMES, SIZE, diagonal
from instrument import Plan, Recording, analyse, reconstruct, simulate
from instrument.schemes import FourierHadamardSettings
from protocols import Floats

CELLS = 8
"""Cells that a pixel has along each axis where the bars are drawn."""

STRENGTHS = (1.5, 0.75, 0.4)
"""Instead of the usual 3."""


def groups(width_px: float, seed: int) -> tuple[Floats, Floats]:
    """Draw four groups, ``(8 m, 8 m)``: the transmission, and 1 where a bar is, -1 where a gap is."""
    object_, places = np.zeros((SIZE * CELLS, SIZE * CELLS)), np.zeros((SIZE * CELLS, SIZE * CELLS))
    top_px, left_px = np.random.default_rng([11, seed]).uniform(14, 20, 2).tolist()
    bar, side = round(width_px * CELLS), round(5 * width_px * CELLS)
    for down_px, right_px, upright in ((0, 0, True), (0, 14, False), (14, 0, False), (14, 14, True)):
        top, left = round((top_px + down_px) * CELLS), round((left_px + right_px) * CELLS)
        for k in range(5):
            along, across = slice(k * bar, (k + 1) * bar), slice(0, side)
            rows, columns = (across, along) if upright else (along, across)
            here = slice(top + rows.start, top + rows.stop), slice(left + columns.start, left + columns.stop)
            object_[here], places[here] = (1.0, 1.0) if k % 2 == 0 else (0.0, -1.0)
    return object_, places


def contrast(image: Floats, places: Floats) -> float:
    """Contrast of an image of the whole field, of any number of pixels."""
    times = len(places) // len(image)
    fine = np.clip(image.repeat(times, 0).repeat(times, 1), 0, None)
    bars, gaps = float(fine[places > 0].mean()), float(fine[places < 0].mean())
    return (bars - gaps) / max(bars + gaps, 1e-12)


def recorded(object_: Floats, sigma: float, seed: int) -> Recording:
    """Record a drawing that moves by motion II."""
    plan = Plan(frames=FRAMES, image_size=SIZE, scheme=FourierHadamardSettings(hadamard_order="hyperbolic"))
    with TemporaryDirectory() as name:
        path = Path(name) / "bars.npy"
        np.save(path, object_)
        scene = {
            "object": str(path),
            "object_height_px": float(SIZE),
            "start_px": [SIZE / 2, SIZE / 2],
            "noise": {"kind": "pixel", "sigma": sigma, "seed": seed},
        }
        return simulate(plan, scene, path=diagonal)


def figures(width_px: float, sigma: float, seed: int) -> list[float]:
    """Contrasts of the truth, of both grids, and of less smoothing."""
    object_, places = groups(width_px, seed)
    recording = recorded(object_, sigma, seed)
    coarse, fine = analyse(recording, grid="1"), analyse(recording, grid="2")
    cells = CELLS // 2
    truth = object_.reshape(2 * SIZE, cells, 2 * SIZE, cells).mean(axis=(1, 3))
    images = [truth, coarse.image, fine.image]
    images += [reconstruct(recording, fine.trajectory, grid=2, strength=strength).image for strength in STRENGTHS]
    return [contrast(image, places) for image in images if image is not None]


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=3)
    seeds: int = parser.parse_args().seeds
    print(" " * 26 + " ".join(f"{head:>8s}" for head in ("truth", "1", "2", *(f"2, {s:g}" for s in STRENGTHS))))
    for width_px, sigma in ((1.5, 0.1), (1.0, 0.025)):
        mean = np.mean([figures(width_px, sigma, seed) for seed in range(seeds)], axis=0)
        print(f"bars of {width_px:g} px, noise {sigma:g}   " + " ".join(f"{value:8.2f}" for value in mean), flush=True)


if __name__ == "__main__":
    main()
