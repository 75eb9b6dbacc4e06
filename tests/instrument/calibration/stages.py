"""Static images on simulated benches, small and quick."""

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from instrument.calibration import Ladder, Visit, static_plan, take_views
from instrument.config import bench_of_tables
from instrument.session import Instrument

TRUE_PX_PER_MM = 2.0
TRUE_ANGLE_DEG = 40.0
POSITIONS_MM = (10.0, 14.0, 19.0)

SCENE: dict[str, Any] = {
    "realism": "realistic",
    "object_at_mm": 10.0,
    "px_per_mm": TRUE_PX_PER_MM,
    "axis_angle_deg": TRUE_ANGLE_DEG,
    "start_px": [7.3, 8.1],
    "fresh_noise": True,
    "noise": {"kind": "poisson", "peak_counts": 4000, "dead_time_s": 0.0, "seed": 5},
}


def bench_with(**scene: Any) -> Instrument:
    """Open simulated devices before a scene."""
    devices: dict[str, Any] = {role: {"driver": "simulated"} for role in ("modulator", "counter", "stage")}
    devices["stage"]["position_mm"] = 2.0
    return Instrument.from_config(bench_of_tables({**devices, "scene": {**SCENE, **scene}}, "bench"))


def visits_of(
    folder: Path,
    scene: Mapping[str, Any] | None = None,
    positions_mm: tuple[float, ...] = POSITIONS_MM,
    *,
    both_sides: bool = False,
) -> list[Visit]:
    """Take 32 px images of all 1024 patterns at some positions."""
    with bench_with(**(scene or {})) as bench:
        return take_views(bench, Ladder(positions_mm, both_sides=both_sides), static_plan(32, 4, frames=1024), folder)
