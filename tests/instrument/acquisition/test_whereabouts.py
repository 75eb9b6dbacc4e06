"""Where the object will be: by the calibration, by a simulated bench, or not at all; and how to keep it inside."""

from pathlib import Path

import numpy as np
import pytest

from instrument.acquisition import Check
from instrument.acquisition.whereabouts import whereabouts
from instrument.config import DisplacementSection
from instrument.plan import MotionPlan, Plan
from instrument.session import Instrument
from protocols import PlanError
from tests.instrument.acquisition.test_checks import checked
from tests.support.benches import bench_toml
from tests.support.calibrations import calibration, displacement

BOX = (10.0, 20.0, 40.0, 50.0)
"""30 px a side, in a field of 128: 87.5 px of room to the right and 77.5 px below."""

ALONG_X = displacement(10.0, 0.0, at_mm=1.0, box_px=BOX)


def plan(frames: int = 1000, **motion: object) -> Plan:
    """0.3 s a thousand frames; from rest at an acceleration that is no matter, 10 mm/s."""
    given = {"velocity_mm_s": 10.0, "acceleration_mm_s2": 1e6, "settle_s": 0.0, "start_mm": 1.0, **motion}
    return Plan(frames=frames, motion=MotionPlan.model_validate(given))


def of(plan_: Plan, known: DisplacementSection = ALONG_X) -> Check:
    """The row about the object."""
    return checked(plan_, known=known)["object"]


def test_travel_and_places_are_told() -> None:
    """10 mm/s x 0.3 s x 10 px/mm = 30 px, from the middle of the box."""
    assert (
        of(plan()).message
        == "30.0 px of travel (+30.0, +0.0), from (25.0, 35.0) to (55.0, 35.0) px in a field of 128 px"
    )
    assert of(plan(velocity_mm_s=-10.0, start_mm=5.0)).message.startswith(
        "30.0 px of travel (-30.0, -0.0), from (65.0, 35.0)"
    )


def test_an_object_that_leaves_is_refused_with_the_frame_and_the_ways_out() -> None:
    """It has 87.5 px of room, and goes 100 px in 1000 frames: frame 875, seen to a four-hundredth of the run."""
    check = of(plan(velocity_mm_s=100 / 3))
    assert check.outcome == "error"
    assert isinstance(check.error, PlanError)
    assert "outside by up to 13 px, from frame 87" in check.error.saw
    assert "lower frames to 87" in check.error.remedy
    assert "lower velocity_mm_s to 29.1" in check.error.remedy
    assert 'set field = "may-leave" in [motion]' in check.error.remedy
    assert "start_mm" not in check.error.remedy, "30 px of object and 100 of travel fit nowhere into 128"


def test_another_start_is_proposed_where_there_is_one() -> None:
    """90 px of travel and 30 of object, from 10 to 130 px: 6.5 px to the left they are in the middle, 0.65 mm less."""
    remedy = of(plan(velocity_mm_s=30.0)).message
    assert "set start_mm = 0.3495, or" in remedy
    assert of(plan(velocity_mm_s=30.0, start_mm=0.35)).outcome == "good"


def test_no_start_is_proposed_where_the_stage_cannot_go() -> None:
    """From 0.3 mm the same would have to begin at -0.35 mm."""
    beyond = displacement(10.0, 0.0, at_mm=0.3, box_px=BOX)
    assert "start_mm" not in of(plan(velocity_mm_s=30.0, start_mm=0.3), beyond).message


def test_each_way_out_leads_in() -> None:
    assert of(plan(872, velocity_mm_s=100 / 3)).outcome == "good"
    assert of(plan(velocity_mm_s=29.1)).outcome == "good"
    said = of(plan(velocity_mm_s=100 / 3, field="may-leave"))
    assert said.outcome == "warning"
    assert said.message.endswith("the plan says that it may leave")


@pytest.mark.parametrize(("velocity_mm_s", "outcome"), [(29.0, "good"), (29.4, "warning"), (29.95, "error")])
def test_the_border_itself_is_a_warning(velocity_mm_s: float, outcome: str) -> None:
    """87.5 px of room in 0.3 s at 10 px/mm: 29.17 mm/s; 2 px beyond it is certain: 29.83 mm/s."""
    assert of(plan(velocity_mm_s=velocity_mm_s)).outcome == outcome


def test_the_uncertainty_of_the_scale_is_granted() -> None:
    """1 % of 9 mm, three times: 2.7 px more."""
    unsure = displacement(10.0, 0.0, sigma=0.1, at_mm=1.0, box_px=BOX)
    assert of(plan(velocity_mm_s=30.5), unsure).outcome == "warning"
    assert of(plan(velocity_mm_s=31.0), unsure).outcome == "error"


def test_without_a_place_only_a_travel_longer_than_the_field_is_certain() -> None:
    """An object of 4 px has 124 px in 128."""
    known = displacement(10.0, 0.0)
    assert of(plan(velocity_mm_s=41.0), known).outcome == "good"
    check = of(plan(velocity_mm_s=43.0), known)
    assert check.outcome == "error"
    assert "the place of the object is not known" in check.message


def test_an_object_at_rest_and_a_bench_that_nobody_measured_say_nothing() -> None:
    assert "object" not in checked(Plan(frames=10), known=ALONG_X)
    assert "is not known" in checked(plan())["object"].message


def test_a_simulated_bench_knows_its_own_object(tmp_path: Path) -> None:
    """Cases of `kinopix check`: 40 mm/s is 102 px along both axes, of which a "B" 36 px high has 80."""
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        said = {
            speed: next(
                check.outcome
                for check in bench.check(Plan(frames=1666, motion=MotionPlan(velocity_mm_s=speed))).checks
                if check.name == "object"
            )
            for speed in (5.0, 25.0, 30.0, 40.0)
        }
    assert said == {5.0: "good", 25.0: "good", 30.0: "good", 40.0: "error"}


@pytest.mark.parametrize(("image_size", "superpixel", "step"), [(64, 4, "0.027"), (128, 2, "0.054"), (256, 1, "0.108")])
def test_a_frame_s_displacement_is_right_at_every_image_size(
    tmp_path: Path, image_size: int, superpixel: int, step: str
) -> None:
    """7.2 px/mm in 128 px, in proportion; 25 mm/s x 300 us."""
    plan_ = Plan(frames=20, image_size=image_size, superpixel=superpixel, motion=MotionPlan(velocity_mm_s=25))
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        (message,) = [check.message for check in bench.check(plan_).checks if check.name == "displacement"]
    assert message.startswith(f"{step} px a frame")


def test_where_a_calibration_and_a_simulated_bench_differ_the_calibration_is_believed(tmp_path: Path) -> None:
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        scene = bench.devices.scene
        grid = plan().grid()
        by_both = whereabouts(plan(), grid, calibration(ALONG_X), scene)
        by_scene = whereabouts(plan(), grid, None, scene)
    assert by_both is not None
    assert by_scene is not None
    assert by_both.travel_px == pytest.approx(30.0, rel=1e-3)
    assert by_scene.travel_px == pytest.approx(10 * 0.3 * 7.2, rel=1e-3)
    np.testing.assert_allclose(by_scene.px_per_mm, 7.2 / np.sqrt(2), rtol=1e-4)
