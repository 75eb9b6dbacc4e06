"""An object that is larger than the field and passes by on the stage: path, and an image that reaches outside the field.

``python -m benchmarks.wide [--seeds 3] [--only TITLE]``, from the repository's root. Letters and a plane side by side, or
spots, go along x (a line says so where not), the middle of the object through the middle of the field in the middle of
the run. The bench is calibrated, with an error of px/mm that a line names. "dB true" is the image along the true path, over all
columns that were in the field in a fifth of the frames; "dB" that of ``analyse(region="wide")`` there, with "MSE" the path's in
px^2 and "far" its largest error in px; "stated" is the share of runs that state an uncertainty, "sigma" the median of that, and
"covered" the share of its 95 % intervals that hold the truth. "off" is how far the stage's profile is off by the calibration.
"""

import argparse
import time
from dataclasses import dataclass, replace
from datetime import UTC, datetime
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import numpy as np
from scipy.ndimage import gaussian_filter

from instrument import Plan, Recording, analyse, reconstruct, simulate
from instrument.config import Calibration, DisplacementSection
from instrument.numerics import displacement_mse, psnr
from instrument.plan import MotionPlan
from instrument.reconstruction import Reconstruction
from protocols import Floats
from sim_backends.bench.objects import BUILT_INS

_PX_PER_MM: Final = 7.2


def letters(size: int, columns: int, gap: int = 6) -> Floats:
    """Draw B, a plane and T side by side, about half as high as the field, then as many again as fill so many columns."""
    drawn = [
        BUILT_INS[name](0.47 * size).cells for name in ("letter-B", "plane", "letter-T", "ring", "letter-B", "plane")
    ]
    high = max(len(cells) for cells in drawn)
    parts = [np.pad(cells, ((0, high - len(cells)), (0, gap))) for cells in drawn]
    return np.hstack(parts)[:, :columns]


def texture(size: int, columns: int, seed: int) -> Floats:
    """Draw spots as large as a twelfth of the field."""
    noise = np.random.default_rng([5, seed]).standard_normal((round(0.7 * size), columns))
    return (gaussian_filter(noise, size / 24) > 0.6 * 24 / size / 3.5).astype(np.float64)


@dataclass(frozen=True)
class Passing:
    """One line of the table."""

    title: str
    size: int
    columns: int
    travel_px: float
    frames: int
    error: float = 0.0
    """Of the calibration, relative."""
    spots: bool = False
    down: bool = False
    noise: str = "pixel"

    def run(self, seed: int) -> tuple[Recording, Floats, tuple[int, int]]:
        """Record it: recording, drawing of the object, and column and row of its upper left corner at displacement 0."""
        drawing = texture(self.size, self.columns, seed) if self.spots else letters(self.size, self.columns)
        drawing = drawing.T if self.down else drawing
        height, width = drawing.shape
        middle = round((self.size - self.travel_px) / 2), self.size // 2
        x, y = middle[::-1] if self.down else middle
        left, top = x - width // 2, y - height // 2
        plan = Plan(frames=self.frames, image_size=self.size)
        motion = MotionPlan(
            velocity_mm_s=self.travel_px / _PX_PER_MM / plan.run_time_s, acceleration_mm_s2=200.0, field="may-leave"
        )
        noise: dict[str, Any] = {"kind": "pixel", "sigma": 0.1, "seed": seed}
        if self.noise == "photons":
            noise = {"kind": "poisson", "peak_counts": 5000.0, "seed": seed}
        with TemporaryDirectory() as name:
            np.save(Path(name) / "object.npy", drawing)
            recording = simulate(
                plan.model_copy(update={"motion": motion}),
                {
                    "object": str(Path(name) / "object.npy"),
                    "object_height_px": float(height),
                    "start_px": [left + width / 2, top + height / 2],
                    "px_per_mm": _PX_PER_MM,
                    "axis_angle_deg": 90.0 if self.down else 0.0,
                    "noise": noise,
                },
            )
        along = _PX_PER_MM * (1 + self.error)
        scale = DisplacementSection(
            date=datetime(2026, 1, 1, tzinfo=UTC),
            image_size=self.size,
            superpixel=plan.superpixel,
            px_per_mm_x=0.0 if self.down else along,
            px_per_mm_y=along if self.down else 0.0,
        )
        return replace(recording, calibration=Calibration(bench={}, displacement=scale)), drawing, (left, top)

    def figures(self, seed: int) -> list[float]:
        """Figures of one seed."""
        recording, drawing, corner = self.run(seed)
        assert recording.truth is not None  # noqa: S101  (a simulated run has one)
        truth_px, gain = recording.truth.displacement_px, recording.photon_counts
        best = reconstruct(recording, truth_px, region="wide")
        started = time.perf_counter()
        found = analyse(recording, region="wide", grid="1")
        took_s = time.perf_counter() - started
        assert found.trajectory is not None  # noqa: S101
        assert found.reconstruction is not None  # noqa: S101
        error_px = found.trajectory.displacement_px - truth_px
        sigma_px = found.trajectory.sigma_px[1:]
        stated = bool(np.isfinite(sigma_px).all())
        return [
            self.error * self.travel_px,
            _quality(best, drawing, corner, truth_px, fit_gain=gain),
            _quality(found.reconstruction, drawing, corner, truth_px, fit_gain=gain),
            displacement_mse(found.trajectory.displacement_px, truth_px),
            float(np.hypot(*error_px.T).max()),
            float(stated),
            float(np.median(sigma_px)) if stated else np.nan,
            float(np.mean(np.abs(error_px[1:]) < 1.96 * sigma_px)) if stated else np.nan,
            found.figures.misfit or np.nan,
            took_s,
        ]


def _quality(
    found: Reconstruction, drawing: Floats, corner: tuple[int, int], truth_px: Floats, *, fit_gain: bool
) -> float:
    """PSNR over the rows and columns that were in the field in a fifth of the frames."""
    image, field = found.at_patterns, found.field
    (height, width), (left, top) = drawing.shape, corner
    around = np.zeros(
        (3 * max(*image.shape, height, width),) * 2
    )  # the drawing with its surroundings, the field at a third
    zero = len(around) // 3
    around[zero + top : zero + top + height, zero + left : zero + left + width] = drawing
    first_y, first_x = zero - field.top, zero - field.left
    true = around[first_y : first_y + image.shape[0], first_x : first_x + image.shape[1]]
    rows, columns = (
        _in_field(count, first, field.width, truth_px[:, axis])
        for count, first, axis in ((image.shape[0], field.top, 1), (image.shape[1], field.left, 0))
    )
    return psnr(image[rows, columns], true[rows, columns], fit_gain=fit_gain)


def _in_field(count: int, first: int, size: int, way_px: Floats) -> slice:
    """Those of ``count`` rows or columns that were in the field in a fifth of the frames, the field beginning at ``first``."""
    at_px = np.arange(count) - first + way_px[:, None]
    used = np.flatnonzero(np.mean((at_px > -0.5) & (at_px < size - 0.5), axis=0) >= 0.2)
    return slice(int(used[0]), int(used[-1]) + 1)


LINES: Final = (
    *(Passing(f"95 px by 64, {way} px", 64, 95, way, 1666) for way in (40, 80, 120)),
    Passing("95 px by 64, 80 px, down", 64, 95, 80, 1666, down=True),
    Passing("95 px by 64, 80 px, 833 f", 64, 95, 80, 833),
    *(
        Passing(f"95 by 64, 80 px, px/mm +{100 * off:g} %", 64, 95, 80, 1666, error=off)
        for off in (0.01, 0.03, 0.06, 0.15)
    ),
    Passing("95 px by 64, 80 px, photons", 64, 95, 80, 1666, noise="photons"),
    Passing("140 px by 64, 110 px", 64, 140, 110, 1666),
    Passing("spots, 140 px by 64, 80 px", 64, 140, 80, 1666, spots=True),
    Passing("spots, the same, +2 %", 64, 140, 80, 1666, error=0.02, spots=True),
    Passing("180 px by 128, 120 px", 128, 180, 120, 1666),
)
"""The lines."""

_HEADS: Final = ("off px", "dB true", "dB", "MSE", "far", "stated", "sigma", "covered", "misfit", "s")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--seeds", type=int, default=3)
    parser.add_argument("--only", default="", help="lines whose title contains this")
    arguments = parser.parse_args()
    seeds: int = arguments.seeds
    only: str = arguments.only
    print(" " * 32 + " ".join(f"{head:>8s}" for head in _HEADS))
    for line in LINES:
        if only in line.title:
            figures = np.array([line.figures(seed) for seed in range(seeds)])
            known = np.where(np.isfinite(figures).any(axis=0), np.nansum(figures, axis=0), np.nan)
            means = known / np.maximum(np.isfinite(figures).sum(axis=0), 1)
            print(f"{line.title:32s}" + " ".join(f"{mean:8.3f}" for mean in means), flush=True)


if __name__ == "__main__":
    main()
