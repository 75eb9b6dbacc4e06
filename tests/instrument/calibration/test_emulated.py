"""The same through the real drivers on their emulators: a stage whose nut has play shows it, and the scale stays right."""

from pathlib import Path
from typing import Any

import pytest

from instrument.calibration import Ladder, displacement_of, static_plan, take_views
from instrument.config import bench_of_tables
from instrument.session import Instrument
from tests.instrument.calibration.stages import SCENE, TRUE_ANGLE_DEG, TRUE_PX_PER_MM

PLAY_MM = 0.2

DEVICES: dict[str, Any] = {
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
        "emulator": {"travel_mm": [0.0, 400.0], "backlash_mm": PLAY_MM},
    },
}


@pytest.mark.thorough
def test_play_is_found_and_scale_and_axis_with_it(tmp_path: Path) -> None:
    tables = {**DEVICES, "scene": SCENE}
    with Instrument.from_config(bench_of_tables(tables, "bench")) as bench:
        ladder = Ladder((10.0, 14.0, 19.0))
        found = displacement_of(take_views(bench, ladder, static_plan(32, 4, frames=1024), tmp_path))
    assert found.px_per_mm == pytest.approx(TRUE_PX_PER_MM, rel=2e-3)
    assert found.axis_angle_deg == pytest.approx(TRUE_ANGLE_DEG, abs=0.15)
    assert found.backlash_mm == pytest.approx(PLAY_MM, abs=0.02)
