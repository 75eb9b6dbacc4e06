"""Displacement from static images: scale and axis within their intervals, and every bad case by its name."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from instrument.calibration import Ladder, Visit, displacement_of, registration, static_plan, take_views
from instrument.numerics import coverage_factor
from protocols import InputError, PlanError, TravelExceeded
from tests.instrument.calibration.stages import POSITIONS_MM, TRUE_ANGLE_DEG, TRUE_PX_PER_MM, bench_with, visits_of
from tests.support.calibrations import DATE


@pytest.fixture(scope="module")
def visits(tmp_path_factory: pytest.TempPathFactory) -> list[Visit]:
    """The bench of ``stages``, up and down."""
    return visits_of(tmp_path_factory.mktemp("views"), both_sides=True)


def test_scale_and_axis_are_found_within_their_intervals(visits: list[Visit]) -> None:
    """4,000 counts a pattern: 0.1 % and 0.1 degree."""
    found = displacement_of(visits, DATE)
    reach = coverage_factor(found.degrees_of_freedom)
    assert found.px_per_mm == pytest.approx(TRUE_PX_PER_MM, rel=1e-3)
    assert found.axis_angle_deg == pytest.approx(TRUE_ANGLE_DEG, abs=0.1)
    assert abs(found.px_per_mm - TRUE_PX_PER_MM) < reach * found.px_per_mm_sigma
    assert 1e-4 < found.px_per_mm_sigma / found.px_per_mm < 1e-3
    assert (found.method, found.date, found.image_size, found.superpixel) == ("static images", DATE, 32, 4)


def test_places_stand_still_after_a_few_rounds(visits: list[Visit], monkeypatch: pytest.MonkeyPatch) -> None:
    """Gauss-Newton doubles its right digits: a common displacement, which no view speaks of, must not keep it going."""
    inside: Any = registration
    rounds: list[float] = []
    step = inside._step

    def counted(*arguments: Any) -> Any:
        corrected = step(*arguments)
        rounds.append(corrected[-1])
        return corrected

    monkeypatch.setattr(inside, "_step", counted)
    displacement_of(visits, DATE)
    assert 2 <= len(rounds) <= 8
    assert rounds[-1] < inside._STANDS


def test_every_image_is_listed_with_position_and_residual(visits: list[Visit]) -> None:
    found = displacement_of(visits, DATE)
    assert [(row.stage_mm, row.approach) for row in found.positions] == [
        *((at, "upward") for at in POSITIONS_MM),
        *((at, "downward") for at in reversed(POSITIONS_MM)),
    ]
    assert found.positions[0].shift_px == (0.0, 0.0)
    x, y = found.positions[2].shift_px
    assert np.hypot(x, y) == pytest.approx(9 * TRUE_PX_PER_MM, abs=0.1)
    residuals = np.array([row.residual_px for row in found.positions])
    assert found.rms_residual_px == pytest.approx(float(np.sqrt(np.mean(residuals**2))), rel=1e-12)
    assert np.abs(residuals.sum(axis=0)).max() < 0.05


def test_the_box_of_the_object_is_known_where_it_was_first(visits: list[Visit]) -> None:
    """A "B" of 9 px, 7 wide, centred at (7.3, 8.1), blurred by 0.5 px."""
    found = displacement_of(visits, DATE)
    assert found.object_at_mm == POSITIONS_MM[0]
    assert found.object_box_px is not None
    left, top, right, bottom = found.object_box_px
    assert (left + right) / 2 == pytest.approx(7.3, abs=1.0)
    assert (top + bottom) / 2 == pytest.approx(8.1, abs=1.0)
    assert 6 <= right - left <= 10
    assert 8 <= bottom - top <= 12


def test_a_stage_without_play_shows_none_and_one_way_says_nothing_of_it(visits: list[Visit]) -> None:
    both = displacement_of(visits, DATE)
    assert both.backlash_mm is not None
    assert both.backlash_sigma_mm is not None
    assert abs(both.backlash_mm) < 4 * both.backlash_sigma_mm < 0.05
    one = displacement_of(visits[:3], DATE)
    assert (one.backlash_mm, one.backlash_sigma_mm) == (None, None)


def test_play_is_found_as_what_the_stage_told_too_much(visits: list[Visit]) -> None:
    """A stage that tells 0.3 mm more on the way up for the same place."""
    played = [
        replace(visit, stage_mm=visit.stage_mm + (0.3 if visit.approach == "upward" else 0.0)) for visit in visits
    ]
    found = displacement_of(played, DATE)
    assert found.backlash_mm == pytest.approx(0.3, abs=0.02)
    assert found.px_per_mm == pytest.approx(TRUE_PX_PER_MM, rel=2e-3)


def test_a_slip_at_one_position_is_named(visits: list[Visit]) -> None:
    slipped = [
        replace(visit, stage_mm=visit.stage_mm + (1.0 if number == 1 else 0.0)) for number, visit in enumerate(visits)
    ]
    with pytest.raises(InputError, match=r"px from where the other positions put it, at 1[45] mm \((up|down)ward\)"):
        displacement_of(slipped)


def test_two_objects_that_move_otherwise_are_told_from_one(visits: list[Visit], tmp_path: Path) -> None:
    """The light of both adds."""
    others = visits_of(tmp_path, {"px_per_mm": 1.0, "axis_angle_deg": 90.0, "start_px": [24.0, 8.0], "object": "disc"})
    both = [
        replace(one, recording=replace(one.recording, values=one.recording.values + other.recording.values))
        for one, other in zip(visits[:3], others, strict=True)
    ]
    with pytest.raises(InputError, match="images that one moving object does not explain"):
        displacement_of(both)


@pytest.mark.parametrize(
    ("scene", "positions_mm", "message"),
    [
        ({"object_level": 0.0}, POSITIONS_MM, r"no object in [23] of 3 images"),
        ({"px_per_mm": 1e-3}, POSITIONS_MM, r"an image that moved by 0\.0\d+ \+- 0\.0\d+ px while the stage told 9 mm"),
        ({}, (10.0, 17.0, 24.0), r"an object that reaches the border of the field at 24 mm \(upward\)"),
        ({}, (10.0, 10.3, 10.6), r"positions too close together: over 0\.6 mm the image moved by 1\.\d\d px"),
    ],
)
def test_what_gives_no_calibration_is_said(
    tmp_path: Path, scene: dict[str, Any], positions_mm: tuple[float, ...], message: str
) -> None:
    with pytest.raises(InputError, match=message):
        displacement_of(visits_of(tmp_path, scene, positions_mm))


def test_what_stands_still_beside_the_object_is_taken_off(tmp_path: Path) -> None:
    scene = {"background": "letter-I", "background_px": [25.0, 6.0]}
    found = displacement_of(visits_of(tmp_path, scene, (10.0, 14.0, 18.0)))
    assert found.px_per_mm == pytest.approx(TRUE_PX_PER_MM, rel=5e-3)
    assert found.axis_angle_deg == pytest.approx(TRUE_ANGLE_DEG, abs=0.3)


@pytest.mark.parametrize("positions_mm", [(), (1.0,), (1.0, 2.0), (1.0, 2.0, 2.005), (1.0, 2.0, float("nan"))])
def test_positions_that_make_no_line_are_refused_before_anything_moves(positions_mm: tuple[float, ...]) -> None:
    with pytest.raises(InputError, match=r"expected 3 or more, at least 0\.01 mm from each other"):
        Ladder(positions_mm)


def test_the_whole_ladder_is_checked_before_the_first_move(tmp_path: Path) -> None:
    with bench_with() as bench:
        before = bench.stage.position().reported_mm
        with pytest.raises(TravelExceeded, match=r"400\.5"):
            take_views(bench, Ladder((10.0, 20.0, 400.0)), static_plan(32, 4, frames=64), tmp_path)
        with pytest.raises(TravelExceeded, match=r"-0\.5"):
            take_views(bench, Ladder((0.0, 20.0, 40.0)), static_plan(32, 4, frames=64), tmp_path)
        with pytest.raises(PlanError):
            take_views(bench, Ladder(POSITIONS_MM), static_plan(2048, 4, frames=64), tmp_path)
        assert bench.stage.position().reported_mm == before
    assert list(tmp_path.iterdir()) == []


def test_the_plan_of_a_static_image_is_the_paper_s() -> None:
    """19,992 patterns, 61.01 % of 128 x 128."""
    plan = static_plan(pattern_rate_hz=100.0)
    assert (plan.patterns, plan.scheme.name, plan.motion) == (19_992, "hadamard", None)
    assert plan.frames / 128**2 == pytest.approx(0.6101, abs=5e-5)
    assert plan.run_time_s == pytest.approx(199.92)
