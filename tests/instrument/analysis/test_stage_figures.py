"""The stage's run against its profile: by what it told, and by what the image says."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from instrument.analysis.stage_figures import stage_figures
from instrument.plan import MotionPlan, Plan
from instrument.recording import Recording, StageLog
from instrument.session import Instrument
from instrument.storage import open_recording
from instrument.tracking import track
from tests.support.calibrations import calibrated_bench_toml, displacement

PLAN = Plan(frames=400, image_size=32, superpixel=4, motion=MotionPlan(start_mm=3.0, velocity_mm_s=25.0))
"""0.12 s: 3 mm of travel, 5.4 px; run-up of 0.6 s, 8.75 mm."""


@pytest.fixture(scope="module")
def recording(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """A bench whose optics make 1.8 px/mm along the diagonal, calibrated so."""
    folder = tmp_path_factory.mktemp("stage")
    known = displacement(1.8, 45.0, image_size=32, superpixel=4, sigma=1e-3)
    scene = 'noise = { kind = "pixel", sigma = 0.02, seed = 1 }\nstart_px = [10.3, 11.2]'
    with Instrument.from_toml(calibrated_bench_toml(folder, known, scene)) as bench:
        assert bench.px_per_mm == pytest.approx(1.8)
        assert bench.axis_angle_deg == pytest.approx(45.0)
        bench.run(PLAN, folder / "run.h5")
    return open_recording(folder / "run.h5")


def test_positions_before_and_after_are_in_the_recording(recording: Recording) -> None:
    """It starts at 3 mm and ends at 3 + 2 x 6.25 + 25 x (0.2 + 0.12) mm; the run-up takes 0.6 s."""
    log = recording.stage
    assert log is not None
    assert (log.time_s[0], log.reported_mm[0]) == (pytest.approx(-0.6, abs=1e-6), 3.0)
    assert (log.reported_mm[-1], log.commanded_mm[-1]) == (pytest.approx(23.5), pytest.approx(23.5))
    assert log.time_s[-1] == pytest.approx(0.12 + 0.1 + 0.5, abs=0.01)
    assert not log.predicted.any()
    assert recording.px_per_mm == pytest.approx(1.8)
    assert recording.axis_angle_deg == pytest.approx(45.0)


def test_a_good_run_says_so(recording: Recording) -> None:
    found = stage_figures(recording, track(recording))
    assert found is not None
    assert found.commanded_mm == pytest.approx(25.0 * 399 * 300e-6)
    assert found.travel_ratio is not None
    assert found.travel_ratio.low < 1 < found.travel_ratio.high
    assert found.end_error_mm == pytest.approx(0.0, abs=2e-3)
    assert found.sentences() == ()
    assert "2.992 mm commanded, the image moved" in found.row()


def test_other_optics_than_the_calibration_s_are_told_with_the_ratio(recording: Recording) -> None:
    assert recording.calibration is not None
    known = recording.calibration.model_copy(
        update={"displacement": displacement(1.8 / 1.67, 45.0, image_size=32, superpixel=4)}
    )
    other = replace(recording, calibration=known)
    found = stage_figures(other, track(other))
    assert found is not None
    (sentence,) = found.sentences()
    assert "px/mm is 1.6" in sentence
    assert "times the calibration" in sentence


@pytest.mark.parametrize(
    ("axis_deg", "away_deg", "lies"),
    [
        (-45.0, 90, ("turned 90", "mirrored, turned 180")),
        (-135.0, 180, ("turned 180", "mirrored, turned 90")),
        (120.0, -75, ("turned 270", "mirrored")),
        (75.0, -30, ()),
    ],
)
def test_a_picture_that_lies_otherwise_than_the_calibration_s_is_told(
    recording: Recording, axis_deg: float, away_deg: float, lies: tuple[str, ...]
) -> None:
    """The image moves along the diagonal, 45 degrees, and all ways are named that turn the axis to within 20 degrees of it.

    Mirrored left to right, -45 becomes 225, and 45 when turned by 180 more; 120 becomes 60.
    """
    assert recording.calibration is not None
    known = recording.calibration.model_copy(
        update={"displacement": displacement(1.8, axis_deg, image_size=32, superpixel=4)}
    )
    other = replace(recording, calibration=known)
    found = stage_figures(other, track(other))
    assert found is not None
    assert found.away_deg is not None
    assert (found.away_deg - away_deg + 180) % 360 - 180 == pytest.approx(0, abs=1.5)
    assert found.lies == lies
    (sentence,) = found.sentences()
    assert f"the image moved {abs(found.away_deg):.0f} degrees {'counter-' * (found.away_deg < 0)}clockwise" in sentence
    assert (" or ".join(lies) or "look at the stage's mounting") in sentence.replace(", or ", " or ")
    assert ("the stage goes the other way" in sentence) == ("turned 180" in lies)


def test_a_stage_that_tells_another_end_is_told(recording: Recording) -> None:
    log = recording.stage
    assert log is not None
    short = replace(recording, stage=replace(log, reported_mm=log.reported_mm - 0.4))
    found = stage_figures(short, track(short))
    assert found is not None
    assert found.end_error_mm == pytest.approx(-0.4, abs=2e-3)
    (sentence,) = found.sentences()
    assert sentence.startswith("the stage tells a position -0.400 mm from where it was sent")


def test_a_lag_is_what_the_positions_are_behind_the_profile(recording: Recording) -> None:
    """0.5 mm behind at 25 mm/s are 20 ms."""
    assert PLAN.motion is not None
    time_s = np.array([-0.7, 0.02, 0.05, 0.09, 0.9])
    told = np.array([PLAN.motion.position_mm(PLAN.run_time_s, moment) for moment in time_s.tolist()])
    told[1:4] -= 0.5
    log = StageLog(time_s, told, np.full(5, 23.5), np.zeros(5, np.bool_))
    late = stage_figures(replace(recording, stage=log), track(recording))
    assert late is not None
    assert late.lag_s == pytest.approx(0.02, rel=1e-6)
    mute = replace(log, predicted=np.array([False, True, True, True, False]))
    silent = stage_figures(replace(recording, stage=mute), track(recording))
    assert silent is not None
    assert silent.lag_s is None


def test_rows_of_the_file_come_back_as_they_were() -> None:
    log = StageLog(np.array([-1.0, 0.5]), np.array([1.0, 2.0]), np.array([3.0, 3.0]), np.array([False, True]))
    again = StageLog.of_rows(log.rows)
    for name in ("time_s", "reported_mm", "commanded_mm", "predicted"):
        np.testing.assert_array_equal(getattr(again, name), getattr(log, name))


def test_an_object_at_rest_has_no_such_figures(recording: Recording, tmp_path: Path) -> None:
    del tmp_path
    still = replace(recording, plan=PLAN.model_copy(update={"motion": None}))
    assert stage_figures(still, track(recording)) is None
