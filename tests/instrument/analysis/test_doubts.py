"""What a run cannot tell is said, each cause in words of its own, and what is stated covers the truth."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from instrument import Plan, Recording, analyse, simulate
from instrument.analysis import Analysis
from instrument.analysis.causes import refuse_beyond
from instrument.config import Calibration
from instrument.measurement import Measurement
from instrument.plan import MotionPlan
from instrument.tracking import as_trajectory
from protocols import InputError
from tests.support.calibrations import SIMULATED, displacement

MOTION = MotionPlan(start_mm=100.0, velocity_mm_s=40.0, field="may-leave")


def recorded(frames: int, motion: MotionPlan | None = None, **scene: Any) -> Recording:
    table = {"object": "letter-B", "object_height_px": 18, "start_px": [22.3, 28.4], **scene}
    return simulate(Plan(frames=frames, image_size=64, superpixel=4, motion=motion), table)


def pixel(seed: int = 1) -> dict[str, Any]:
    return {"kind": "pixel", "sigma": 0.1, "seed": seed}


def photons(counts: float, seed: int = 1) -> dict[str, Any]:
    return {"kind": "poisson", "peak_counts": counts, "seed": seed}


def furthest(found: Analysis) -> float:
    """Largest error of the displacement, in half-widths of the 95 % interval."""
    assert found.trajectory is not None
    assert found.recording.truth is not None
    error = np.abs(found.trajectory.displacement_px - found.recording.truth.displacement_px)[1:]
    return float((error / (1.96 * found.trajectory.sigma_px[1:])).max())


def test_one_frame_tells_of_no_motion() -> None:
    found = analyse(recorded(1, noise=pixel()))
    assert found.figures.travel_px is None
    assert found.figures.sigma_px is None
    assert "travel" not in found.figures.rows()
    (doubt,) = found.figures.doubts
    assert doubt.startswith("one frame cannot tell of a motion, and its image is hardly more than its total light")


@pytest.mark.parametrize("seed", range(4))
def test_few_frames_have_the_interval_of_noise_that_is_only_estimated(seed: int) -> None:
    found = analyse(recorded(10, noise=pixel(seed)))
    assert found.figures.sigma_px is not None
    assert furthest(found) < 1.5
    assert [doubt.split(":")[0] for doubt in found.figures.doubts] == ["10 frames are too few for an image"]


def test_where_the_stage_was_is_said_of_a_run_without_an_object() -> None:
    """The ramp up to 40 mm/s at 50 mm/s^2 takes 16 mm, and settling 4: the run begins at 120 mm and goes over 4.8."""
    dark = recorded(400, MOTION, object_at_mm=0.0, noise=pixel())
    with pytest.raises(InputError, match=r"no object in the light while the stage went from 120 to 124\.8 mm: "):
        analyse(dark)


def test_a_calibration_tells_that_the_object_was_never_in_the_field() -> None:
    """Its left edge is at 10 px at 0 mm and moves by 2 px/mm: at 120 mm it is at 250, 186.5 px beyond 63.5."""
    section = displacement(2.0, 0.0, image_size=64, superpixel=4, at_mm=0.0, box_px=(10.0, 20.0, 28.0, 38.0))
    known = Calibration(bench=SIMULATED, displacement=section)
    dark = replace(recorded(400, MOTION, object_at_mm=0.0, noise=pixel()), calibration=known)
    with pytest.raises(
        InputError, match=r"the object was never in the field, by the calibration 186 px away from it: "
    ):
        analyse(dark)


def test_light_that_is_the_same_for_every_pattern_has_no_object_in_it() -> None:
    ambient = recorded(400, object_level=0.0, ambient_level=0.3, noise=photons(500.0))
    with pytest.raises(InputError, match="the same for every pattern and its complement: no object in it"):
        analyse(ambient)


def test_what_stands_still_though_the_stage_moved_is_no_object_that_rides_on_it() -> None:
    moved = MotionPlan(velocity_mm_s=20.0)
    still = analyse(recorded(400, moved, object_level=0.0, background="letter-I", noise=photons(2000.0)))
    (doubt,) = still.figures.doubts
    assert doubt.startswith("the stage was sent over 2.39 mm, and what is seen stands still, within 0.")
    assert "a background without the object" in doubt
    assert still.figures.stage is not None
    assert still.figures.stage.at_rest_within_px is not None
    rides = analyse(recorded(400, moved, noise=photons(2000.0)))
    assert rides.figures.stage is not None
    assert rides.figures.stage.at_rest_within_px is None
    assert rides.figures.doubts == ()


def test_a_lamp_that_goes_nearly_dark_is_told_and_its_dark_frames_are_left_out() -> None:
    """0.2 of the mean is reached where sin = -0.8 / 0.98: 19 % of the time, and a frame before and after."""
    found = analyse(recorded(600, MotionPlan(velocity_mm_s=40.0), led_flicker=0.98, noise=photons(2000.0)))
    (doubt,) = found.figures.doubts
    assert doubt.startswith("the lamp flickers by 98 % at 100 Hz: ")
    assert 0.18 * 600 < found.figures.frames_masked < 0.26 * 600
    assert found.figures.psnr_db is not None
    assert found.figures.psnr_db > 18
    assert furthest(found) < 1.5
    assert found.figures.misfit == pytest.approx(1.0, abs=0.15)


def test_a_lamp_that_fades_to_a_tenth_is_no_object_that_leaves() -> None:
    fading = recorded(600, MotionPlan(velocity_mm_s=40.0), led_drift_per_s=-0.9 / 0.18, noise=photons(2000.0))
    found = analyse(fading)
    (doubt,) = found.figures.doubts
    assert "the object stays inside by its own path, so that the lamp drifts" in doubt
    assert furthest(found) < 1.5


def test_a_path_that_may_be_off_by_whole_periods_is_told() -> None:
    """A period is 32 px in a field of 64; 6.5 photons of an all-on pattern leave more than an eighth of it, 4 px."""
    scene = {"object": "bars", "object_height_px": 2, "start_px": [27, 26], "noise": photons(6.5)}
    figures = analyse(simulate(Plan(frames=200, image_size=64), scene)).figures
    assert figures.sigma_px is not None
    (told,) = [doubt for doubt in figures.doubts if "fringes repeat every 32 px" in doubt]
    assert float(told.removeprefix("the displacement is known to ").split(" px")[0]) > 4


def test_a_path_as_wide_as_the_field_is_refused_with_what_makes_such_paths() -> None:
    """Of 64 px, it must leave 4. The light of the second run falls by 80 %."""
    run = Measurement.of(recorded(100, noise=pixel()))
    falling = replace(run, values=run.values * np.linspace(1.0, 0.2, 100)[:, None])
    wide, fits = (as_trajectory(np.linspace([0.0, 0.0], [way, 1.0], 100), 100, 3e-4) for way in (60.1, 59.9))
    with pytest.raises(InputError, match=r"a path of 60, 1 px .* though the light stays"):
        refuse_beyond(run, wide)
    with pytest.raises(
        InputError, match=r"light that changes by 6. %; expected an object all of which is inside the field in 200"
    ):
        refuse_beyond(falling, wide)
    refuse_beyond(run, fits)


@pytest.mark.thorough
def test_an_image_from_border_to_border_is_doubted() -> None:
    """A letter 90 px high and 65 wide moves by 12 px in a field of 64: none of its ends is ever inside all the time."""
    plan = Plan(frames=300, image_size=64)
    table = {"object": "letter-B", "object_height_px": 90, "start_px": [32.0, 32.0], "noise": pixel()}
    found = analyse(simulate(plan, table, path=lambda time_s: np.stack([120 * time_s, 0 * time_s], axis=1)))
    assert [doubt for doubt in found.figures.doubts if "from border to border" in doubt]
