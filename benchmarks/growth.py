"""Time and memory of the analysis as runs get longer and images larger: a table, ``growth.png``, and the fitted exponents.

``OPENBLAS_NUM_THREADS=1 python -m benchmarks.growth [--out FOLDER] [--repeats 3]``, from the repository's root.

Frames: 416 and x2, x4, x8 at 128 x 128. Image: 64, 128, 256 at 1,664 frames, object and way in proportion. Motion II over the
run, noise of 0.1 on every pixel, the image in the region.
"""

import argparse
import os
import time
import tracemalloc
from dataclasses import dataclass
from pathlib import Path
from statistics import median

import matplotlib as mpl

mpl.use("Agg")

import numpy as np
from matplotlib import pyplot as plt

from benchmarks.scenes import placed, recorded
from instrument.joint import refine
from instrument.patterns import hadamard_order
from instrument.plan import Plan
from instrument.reconstruction import Field, Region, ShiftedHadamard, reconstruct
from instrument.recording import Recording
from instrument.tracking import track
from protocols import Floats

FRAMES = (416, 832, 1664, 3328)
SIZES = (64, 128, 256)


@dataclass(frozen=True)
class Cost:
    """Of one run; times are medians."""

    frames: int
    size: int
    track_s: float
    image_s: float
    """Reconstruction with a given motion."""
    whole_s: float
    """Tracking, refinement and image."""
    products_ms: float
    """One product with A and one with its transpose, on the full field."""
    rows_mb: float
    """Of the operator, on the full field."""
    peak_mb: float
    """Allocated at most during the whole analysis."""


def run(frames: int, size: int) -> Recording:
    """A "B" of 9/32 of the field that goes 66/128 of the field along the diagonal."""
    corner_px = 22 * size // 128
    image = placed("letter-B", corner_px, corner_px, height_px=36 * size / 128, size=size)
    plan = Plan(frames=frames, image_size=size)

    def path(time_s: Floats) -> Floats:
        part = time_s / plan.run_time_s
        way: Floats = (66 * size / 128 / np.sqrt(2) * (0.77 * part + 0.23 * part**2))[:, None] * np.ones(2)
        return way

    return recorded(plan, image, path, sigma=0.1)


def cost(frames: int, size: int, repeats: int) -> Cost:
    """Measure one run."""
    recording = run(frames, size)
    truth = recording.truth
    assert truth is not None  # noqa: S101  (simulated)
    rows = ShiftedHadamard.single(
        hadamard_order(size, "tv", frames), truth.displacement_px, Field(size), Region.whole(size)
    )
    image = truth.image.astype(np.float32).ravel()
    took: list[tuple[float, ...]] = []
    for _ in range(repeats):
        marks = [time.perf_counter()]
        tracked = track(recording)
        marks.append(time.perf_counter())
        refine(recording, tracked)
        marks.append(time.perf_counter())
        reconstruct(recording, truth.displacement_px)
        marks.append(time.perf_counter())
        for _ in range(10):
            rows.rmatvec(rows.matvec(image))
        marks.append(time.perf_counter())
        took.append(tuple(np.diff(marks).tolist()))
    tracked_s, refined_s, imaged_s, products_s = (median(column) for column in zip(*took, strict=True))
    tracemalloc.start()
    refine(recording, track(recording))
    peak_mb = tracemalloc.get_traced_memory()[1] / 1e6
    tracemalloc.stop()
    whole_s = tracked_s + refined_s
    return Cost(frames, size, tracked_s, imaged_s, whole_s, products_s * 100, rows.nbytes / 1e6, peak_mb)


def exponent(along: list[int], costs: list[float]) -> float:
    """Slope of the cost in a double logarithmic plot."""
    return float(np.polyfit(np.log(along), np.log(costs), 1)[0])


def draw(by_frames: list[Cost], by_size: list[Cost], path: Path) -> None:
    """Plot times over frames and over pixels a side."""
    figure, axes = plt.subplots(1, 2, figsize=(9, 4), layout="constrained", sharey=True, dpi=130)
    for axis, costs, along, label in (
        (axes[0], by_frames, [c.frames for c in by_frames], f"frames, at {by_frames[0].size} x {by_frames[0].size}"),
        (axes[1], by_size, [c.size for c in by_size], f"pixels a side, {by_size[0].frames} frames"),
    ):
        curves = {
            "tracking, refinement and image": [c.whole_s for c in costs],
            "image": [c.image_s for c in costs],
            "tracking": [c.track_s for c in costs],
            "products, forward and back": [c.products_ms / 1e3 for c in costs],
        }
        for name, values in curves.items():
            axis.loglog(along, values, "o-", label=f"{name}: power {exponent(along, values):.1f}")
        axis.set_xlabel(label)
        axis.set_xticks(along, [str(n) for n in along], minor=False)
        axis.minorticks_off()
        axis.grid(visible=True, alpha=0.3)
        axis.legend(fontsize=7)
    axes[0].set_ylabel("time / s")
    path.parent.mkdir(parents=True, exist_ok=True)
    figure.savefig(path)  # pyright: ignore[reportUnknownMemberType]  (as matplotlib types it)
    plt.close(figure)


def main() -> None:
    """Print the table and what it says; draw it."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, default=Path(), help="folder for growth.png")
    parser.add_argument("--repeats", type=int, default=3, help="of which medians are taken")
    arguments = parser.parse_args()
    threads = os.environ.get("OPENBLAS_NUM_THREADS", "all")
    print(f"cores {os.cpu_count()}, load {os.getloadavg()[0]:.1f}, BLAS threads {threads}")
    print("frames  size   track s   image s   whole s  products ms  rows MB  peak MB")
    cost(FRAMES[0], SIZES[0], 1)  # caches and libraries warm
    cells = dict.fromkeys([(frames, 128) for frames in FRAMES] + [(1664, size) for size in SIZES])
    done: dict[tuple[int, int], Cost] = {}
    for frames, size in cells:
        c = cost(frames, size, arguments.repeats)
        done[frames, size] = c
        print(
            f"{frames:6d} {size:5d} {c.track_s:9.4f} {c.image_s:9.3f} {c.whole_s:9.3f} {c.products_ms:12.2f}"
            f" {c.rows_mb:8.2f} {c.peak_mb:8.1f}",
            flush=True,
        )
    by_frames, by_size = [done[frames, 128] for frames in FRAMES], [done[1664, size] for size in SIZES]
    path = arguments.out / "growth.png"
    draw(by_frames, by_size, path)
    growth = [
        exponent([c.frames for c in by_frames], [c.whole_s for c in by_frames]),
        exponent([c.size for c in by_size], [c.whole_s for c in by_size]),
        exponent([c.frames for c in by_frames], [c.rows_mb for c in by_frames]),
        exponent([c.size for c in by_size], [c.rows_mb for c in by_size]),
        exponent([c.frames for c in by_frames], [c.peak_mb for c in by_frames]),
        exponent([c.size for c in by_size], [c.peak_mb for c in by_size]),
    ]
    print(
        f"Time of the whole analysis grows as frames^{growth[0]:.2f} and size^{growth[1]:.2f} (pixels a side); "
        f"memory of the rows as frames^{growth[2]:.2f} and size^{growth[3]:.2f} (a dense matrix: 1 and 2), "
        f"and of the whole analysis as frames^{growth[4]:.2f} and size^{growth[5]:.2f}. Drawn in {path}."
    )


if __name__ == "__main__":
    main()
