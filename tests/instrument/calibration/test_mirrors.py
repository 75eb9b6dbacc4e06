"""Leak, edge loss and delay of a simulated bench, found by ordinary runs."""

from pathlib import Path
from typing import Any

import pytest

from instrument.calibration import PictureField, calibrate_mirrors
from protocols import InputError
from tests.instrument.calibration.benches import bench_of


@pytest.mark.parametrize(
    ("scene", "leak", "late_us", "edge"),
    [
        ({}, 0.0, 0.0, 0.0),
        ({"mirror_transition_s": 4e-6, "edge_loss": 0.02}, 0.04, 2.0, 0.02),
        ({"mirror_transition_s": 12.5e-6, "edge_loss": 0.1}, 0.125, 6.25, 0.1),
        ({"mirror_transition_s": 4e-6, "mirror_settling_s": 8.5e-6, "ambient_level": 0.1}, 0.0825, 4.125, 0.0),
    ],
)
def test_leak_delay_and_edge_loss(
    tmp_path: Path, scene: dict[str, Any], leak: float, late_us: float, edge: float
) -> None:
    """Transition / 2 + settling / 4, in pictures of 50 us and in us."""
    with bench_of(scene, dead_time_s=2e-8, dark_rate_hz=600.0) as bench:
        found = calibrate_mirrors(bench, PictureField(tmp_path, 32, 2), seconds=0.5)
    section = found.section
    assert section.leak.value == pytest.approx(leak, abs=0.005)
    assert section.leak.value == pytest.approx(leak, abs=4 * section.leak.sigma)
    assert section.edge_loss.value == pytest.approx(edge, abs=0.01)
    assert section.edge_loss.value == pytest.approx(edge, abs=4 * section.edge_loss.sigma)
    assert section.late_s.value == pytest.approx(late_us * 1e-6, abs=4 * section.late_s.sigma)
    assert section.late_s.sigma < 0.3e-6
    assert section.early.value == pytest.approx(0.0, abs=4 * section.early.sigma)
    assert section.whole_pictures_late == 0
    assert section.leak_at(100e-6).value == pytest.approx(section.leak.value / 2)
    assert section.leak_at(100e-6).sigma == pytest.approx(section.leak.sigma / 2)
    assert found.doubts == ()


def test_cells_of_four_mirrors_have_half_the_borders(tmp_path: Path) -> None:
    with bench_of({"edge_loss": 0.1}) as bench:
        found = calibrate_mirrors(bench, PictureField(tmp_path, 32, 4), seconds=0.5)
    for loss in found.loss_by_cell:
        assert loss.value == pytest.approx(0.1, abs=4 * loss.sigma)
    assert found.loss_by_cell[1].sigma == pytest.approx(2 * found.loss_by_cell[0].sigma, rel=0.1)


@pytest.mark.parametrize("late", [1, -2])
def test_patterns_that_come_late_by_whole_pictures_are_named(tmp_path: Path, late: int) -> None:
    with bench_of({"patterns_late": late, "mirror_transition_s": 4e-6, "edge_loss": 0.02}) as bench:
        found = calibrate_mirrors(bench, PictureField(tmp_path, 32, 2), seconds=0.5)
    assert found.section.whole_pictures_late == late
    assert found.section.leak.value == pytest.approx(0.04, abs=0.005)
    assert found.section.edge_loss.value == pytest.approx(0.02, abs=0.01)
    assert f"{late} pictures" in found.doubts[0]


def test_without_light_it_says_so(tmp_path: Path) -> None:
    with bench_of({"object_level": 0.0}, dark_rate_hz=600.0) as bench, pytest.raises(InputError, match="lamp on"):
        calibrate_mirrors(bench, PictureField(tmp_path, 32, 2), seconds=0.2)
