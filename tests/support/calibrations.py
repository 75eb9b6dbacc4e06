"""Calibrations for tests, of the simulated devices."""

import math
from datetime import UTC, datetime
from pathlib import Path

from instrument.config import CalibratedDevice, Calibration, DisplacementSection, write_calibration
from tests.support.benches import bench_toml

DATE = datetime(2023, 4, 1, 12, 30, tzinfo=UTC)

SIMULATED = {
    "modulator": CalibratedDevice(vendor="Kinopix", model="simulated DLP7000"),
    "counter": CalibratedDevice(vendor="Kinopix", model="simulated H10682 and counter"),
    "stage": CalibratedDevice(vendor="Kinopix", model="simulated KA400Z"),
}

MEASURED_SCENE = """object_at_mm = 10.0
px_per_mm = 2.0
axis_angle_deg = 40.0
start_px = [7.3, 8.1]
blur_px = 0.5
fresh_noise = true
noise = { kind = "poisson", peak_counts = 6000, seed = 5 }"""
"""A bench on which a displacement is measured: 2 px/mm at 40 degrees, and the light of 6,000 counts of an all-on pattern."""


def displacement(
    px_per_mm: float = 7.2,
    angle_deg: float = 45.0,
    *,
    image_size: int = 128,
    superpixel: int = 2,
    sigma: float = 0.0,
    at_mm: float | None = None,
    box_px: tuple[float, float, float, float] | None = None,
) -> DisplacementSection:
    """A scale along an axis; ``sigma`` of both components in px/mm."""
    angle = math.radians(angle_deg)
    return DisplacementSection(
        date=DATE,
        image_size=image_size,
        superpixel=superpixel,
        px_per_mm_x=px_per_mm * math.cos(angle),
        px_per_mm_y=px_per_mm * math.sin(angle),
        covariance=((sigma**2, 0.0), (0.0, sigma**2)),
        object_at_mm=at_mm,
        object_box_px=box_px,
    )


def calibration(section: DisplacementSection | None = None) -> Calibration:
    """A calibration of the simulated devices with a displacement section."""
    return Calibration(bench=SIMULATED, displacement=section or displacement())


def calibrated_bench_toml(folder: Path, section: DisplacementSection, scene: str = "") -> Path:
    """Write a bench.toml of simulated devices that names ``mine.toml``, a calibration with that section, beside it."""
    write_calibration(folder / "mine.toml", calibration(section))
    path = bench_toml(folder, scene)
    path.write_text('calibration = "mine.toml"\n' + path.read_text())
    return path
