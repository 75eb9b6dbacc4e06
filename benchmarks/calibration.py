"""Calibration of displacement, many times, on benches whose scale and axis are drawn at random: do the stated intervals hold?

    python -m benchmarks.calibration                   # 100 draws on simulated devices
    python -m benchmarks.calibration --emulators --draws 10   # through the real drivers
    python -m benchmarks.calibration --motions --draws 20     # speed and acceleration of the paper's two motions
    python -m benchmarks.calibration --frames 8192 --draws 10 # eight times the patterns: the scale to 0.06 %

Scenes are ``realistic`` and count photons, 250 in an all-lit picture. Every draw has another scale, angle, place and noise. The
figures of one draw take some seconds.
"""

import argparse
import math
import tempfile
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Final

import numpy as np

from instrument.calibration import Ladder, displacement_of, static_plan, take_views
from instrument.config import DisplacementSection, bench_of_tables
from instrument.joint import refine
from instrument.measurement import first_light
from instrument.numerics import coverage_factor
from instrument.plan import MotionPlan, Plan
from instrument.session import Instrument
from instrument.tracking import MotionFit, track

SIZE_PX = 32
START_MM = 10.0
PEAK_COUNTS = 250.0

SIMULATED: dict[str, Any] = {role: {"driver": "simulated"} for role in ("modulator", "counter", "stage")}

EMULATED: dict[str, Any] = {
    "modulator": {"driver": "dlp7000", "transport": "alp-emulator"},
    "counter": {"driver": "ni", "transport": "ni-emulator"},
    "stage": {
        "driver": "ka400z",
        "transport": "mc600-emulator",
        "dialect": "mc600",
        "lead_mm": 4.0,
        "microsteps": 8,
        "travel_mm": [0.0, 400.0],
        "max_velocity_mm_s": 50.0,
        "max_acceleration_mm_s2": 200.0,
        "home_velocity_mm_s": 5.0,
        "emulator": {"travel_mm": [0.0, 400.0]},
    },
}


@dataclass(frozen=True)
class Draw:
    """A bench that nobody has seen before."""

    px_per_mm: float
    angle_deg: float
    scene: Mapping[str, Any]

    @classmethod
    def of(cls, random: np.random.Generator) -> "Draw":
        """Draw scale, axis, place and noise."""
        px_per_mm, angle_deg = float(random.uniform(1.5, 2.2)), float(random.uniform(30, 60))
        scene = {
            "realism": "realistic",
            "px_per_mm": px_per_mm,
            "axis_angle_deg": angle_deg,
            "object_at_mm": START_MM,
            "start_px": random.uniform(6.5, 7.5, 2).tolist(),
            "fresh_noise": True,
            "noise": {"kind": "poisson", "peak_counts": PEAK_COUNTS, "seed": int(random.integers(1 << 30))},
        }
        return cls(px_per_mm, angle_deg, scene)

    def positions_mm(self, count: int) -> tuple[float, ...]:
        """Positions over 17.5 px along the axis that the image moves more along."""
        angle = math.radians(self.angle_deg)
        span_mm = 17.5 / max(math.cos(angle), math.sin(angle)) / self.px_per_mm
        return tuple(np.round(START_MM + np.linspace(0, span_mm, count), 2).tolist())


def calibrated(draw: Draw, devices: Mapping[str, Any], frames: int, positions: int) -> DisplacementSection:
    """Calibrate a bench as the command does."""
    tables = {**devices, "scene": draw.scene}
    with (
        tempfile.TemporaryDirectory() as folder,
        Instrument.from_config(bench_of_tables(tables, "bench")) as bench,
    ):
        ladder = Ladder(draw.positions_mm(positions))
        return displacement_of(take_views(bench, ladder, static_plan(SIZE_PX, 4, 1000.0, frames), Path(folder)))


def scales(arguments: argparse.Namespace) -> None:
    """Print the errors of every draw, and how often the intervals hold."""
    random = np.random.default_rng(arguments.seed)
    devices = EMULATED if arguments.emulators else SIMULATED
    rows: list[tuple[float, float, float, float, bool, bool]] = []
    for number in range(1, arguments.draws + 1):
        draw = Draw.of(random)
        found = calibrated(draw, devices, arguments.frames, arguments.positions)
        reach = coverage_factor(found.degrees_of_freedom)
        of_scale, of_angle = found.px_per_mm - draw.px_per_mm, found.axis_angle_deg - draw.angle_deg
        row = (
            100 * of_scale / draw.px_per_mm,
            of_angle,
            100 * found.px_per_mm_sigma / found.px_per_mm,
            found.axis_angle_sigma_deg,
            abs(of_scale) < reach * found.px_per_mm_sigma,
            abs(of_angle) < reach * found.axis_angle_sigma_deg,
        )
        rows.append(row)
        print(
            f"{number:3d}: {draw.px_per_mm:.3f} px/mm {row[0]:+.3f} % (sigma {row[2]:.3f}), "
            f"{draw.angle_deg:.2f} degrees {row[1]:+.3f} (sigma {row[3]:.3f})",
            flush=True,
        )
    table = np.array(rows, np.float64)
    rms, mean, (scale_held, angle_held) = (
        np.sqrt(np.mean(table[:, :2] ** 2, axis=0)),
        table.mean(axis=0),
        table[:, 4:].sum(axis=0),
    )
    print(
        f"px/mm: rms error {rms[0]:.3f} %, stated {mean[2]:.3f} %; the 95 % interval holds in {scale_held:.0f} of {len(rows)}"
    )
    print(
        f"angle: rms error {rms[1]:.3f} degrees, stated {mean[3]:.3f}; the 95 % interval holds in {angle_held:.0f} of {len(rows)}"
    )


MOTIONS: dict[str, MotionPlan] = {
    "25 mm/s": MotionPlan(velocity_mm_s=25.0),
    "50 mm/s^2 to 25 mm/s": MotionPlan(velocity_mm_s=25.0, acceleration_mm_s2=50.0, acquire="from-rest"),
}


FALLING: Final = [[0.65, 0.825, 0.65], [0.825, 1.0, 0.825], [0.65, 0.825, 0.65]]
"""1 - 0.35 r^2 of the corner's r, at edges and middle: the realistic bench's illumination, as ``calibrate light`` measures it."""


def motions(arguments: argparse.Namespace) -> None:
    """Print errors of speed and acceleration of the paper's two motions, 1,666 frames at 128 px, with the true scale given."""
    random = np.random.default_rng(arguments.seed)
    for name, realism, falloff, light in (
        ("ideal", "ideal", None, {}),
        ("realistic, evenly lit", "realistic", 0.0, {}),
        ("realistic", "realistic", None, {}),
        ("realistic, its illumination known", "realistic", None, {"light": {"profile": FALLING}}),
    ):
        errors: dict[str, list[tuple[float, float, float, bool]]] = {}
        for _ in range(arguments.draws):
            scene: dict[str, Any] = {
                "realism": realism,
                "start_px": random.uniform(32, 33, 2).tolist(),
                "noise": {"kind": "poisson", "peak_counts": PEAK_COUNTS, "seed": int(random.integers(1 << 30))},
                **({} if falloff is None else {"illumination_falloff": falloff}),
            }
            for motion_name, motion in MOTIONS.items():
                fit, truth = measured({**light, "scene": scene}, motion)
                for quantity, true in truth.items():
                    found = getattr(fit, quantity)
                    row = (found.value - true, found.sigma, true, found.low <= true <= found.high)
                    errors.setdefault(f"{motion_name}: {quantity}", []).append(row)
        for what, rows in errors.items():
            table = np.array(rows, np.float64)
            true, rms = table[0, 2], float(np.sqrt(np.mean(table[:, 0] ** 2)))
            relative = f" ({100 * rms / abs(true):.2f} %)" if true else ""
            print(
                f"{name}; {what} {true:.4g}: rms error {rms:.4g}{relative}, stated {table[:, 1].mean():.4g}; the 95 % interval "
                f"holds in {table[:, 3].sum():.0f} of {len(rows)}",
                flush=True,
            )


def measured(tables: Mapping[str, Any], motion: MotionPlan) -> tuple[MotionFit, dict[str, float]]:
    """Record and analyse one motion; give the fit in mm, and the truth."""
    with (
        tempfile.TemporaryDirectory() as folder,
        Instrument.from_config(bench_of_tables({**SIMULATED, **tables}, "bench")) as bench,
    ):
        recording = bench.run(Plan(frames=1666, motion=motion), Path(folder) / "run.h5")
    measurement = first_light(recording)
    path = refine(measurement, track(measurement)).trajectory
    angle = math.radians(45.0)
    scale = DisplacementSection.model_validate(
        {
            "date": "2023-04-01T00:00:00Z",
            "image_size": 128,
            "superpixel": 2,
            "px_per_mm_x": 7.2 * math.cos(angle),
            "px_per_mm_y": 7.2 * math.sin(angle),
        }
    )
    fit = replace(path, scale=scale).motion_mm
    if fit is None:
        raise SystemExit("a path without a covariance")
    first_s, last_s = float(path.time_s[0]), float(path.time_s[-1])
    if motion.acquire == "cruise":
        return fit, {"speed": motion.velocity_mm_s, "acceleration": 0.0}
    acceleration = motion.acceleration_mm_s2
    return fit, {"speed": acceleration * (first_s + last_s) / 2, "acceleration": acceleration}


def main() -> None:
    """Run what the arguments ask for."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--draws", type=int, default=100)
    parser.add_argument(
        "--frames", type=int, default=1024, help="Hadamard patterns of an image, with their complements"
    )
    parser.add_argument("--positions", type=int, default=5)
    parser.add_argument("--seed", type=int, default=2023)
    parser.add_argument("--emulators", action="store_true", help="through the real drivers on their emulators")
    parser.add_argument("--motions", action="store_true", help="speed and acceleration instead")
    arguments = parser.parse_args()
    motions(arguments) if arguments.motions else scales(arguments)


if __name__ == "__main__":
    main()
