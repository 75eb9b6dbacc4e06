"""A plan's own figures by hand: times, distances, and which plans contradict themselves."""

import json
from typing import Any

import pytest
from pydantic import ValidationError

from instrument.plan import MotionPlan, Plan
from instrument.schemes import FourierHadamardSettings


@pytest.mark.parametrize(
    ("rate_hz", "picture_us"),
    [(20_000, 50), (22_727, 44), (15_000, 67), (300_000, 3), (700_000, 1), (1e6, 1), (0.5, 2_000_000)],
)
def test_boards_keep_whole_microseconds(rate_hz: float, picture_us: int) -> None:
    plan = Plan(frames=1, pattern_rate_hz=rate_hz)
    assert plan.picture_time_us == picture_us
    assert plan.picture_time_s == pytest.approx(picture_us * 1e-6)


def test_times_of_a_run_by_hand() -> None:
    """1,666 frames of six patterns of 50 us; a pair of two for the plain Hadamard scheme."""
    plan = Plan(frames=1666)
    assert (plan.patterns_per_frame, plan.patterns) == (6, 9996)
    assert plan.frame_time_s == pytest.approx(300e-6)
    assert plan.run_time_s == pytest.approx(0.4998)
    pairs = Plan.model_validate({"frames": 10, "scheme": "hadamard"})
    assert pairs.patterns == 20
    assert pairs.frame_time_s == pytest.approx(100e-6)
    assert plan.grid(1920, 1080).origin == ((1080 - 256) // 2, (1920 - 256) // 2)


@pytest.mark.parametrize(
    ("motion", "run_up_s", "end_mm"),
    [
        # 25 mm/s at 50 mm/s^2: ramps of 0.5 s and 6.25 mm; 2 x 6.25 + 25 x (0.2 + 0.4)
        (MotionPlan(velocity_mm_s=25), 0.6, 27.5),
        (MotionPlan(velocity_mm_s=-25, start_mm=100), 0.6, 72.5),
        (MotionPlan(velocity_mm_s=25, settle_s=0), 0.5, 22.5),
        (MotionPlan(velocity_mm_s=25, acquire="from-rest", acceleration_mm_s2=250), 0.0, 2.5 + 25 * 0.3),
        # shorter than its ramp of 0.5 s: a whole ramp up and down all the same
        (MotionPlan(velocity_mm_s=25, acquire="from-rest"), 0.0, 12.5),
    ],
)
def test_where_the_stage_ends_after_a_run_of_400_ms(motion: MotionPlan, run_up_s: float, end_mm: float) -> None:
    assert motion.run_up_s == pytest.approx(run_up_s)
    assert motion.end_mm(0.4) == pytest.approx(end_mm)
    assert motion.profile.velocity_mm_s == 25


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"image_size": 4}, "image_size is 4: Hadamard patterns need a power of two, 8 or more"),
        ({"image_size": 100}, "image_size is 100"),
        ({"pattern_rate_hz": 1.1e6}, "pattern_rate_hz is 1.1e\\+06: at most 1e6"),
        ({"frames": 0}, "greater than 0"),
        ({"motion": {"velocity_mm_s": 0}}, r"leave out the whole \[motion\] table"),
        ({"scheme": {"upsampling": 3}}, "it must divide superpixel = 2"),
        ({"speed": 3}, "Extra inputs are not permitted"),
    ],
)
def test_a_plan_that_contradicts_itself_is_refused(wrong: dict[str, Any], said: str) -> None:
    with pytest.raises(ValidationError, match=said):
        Plan.model_validate({"frames": 10, **wrong})


def test_the_smallest_image_is_eight_pixels() -> None:
    assert Plan(frames=1, image_size=8).image_size == 8


def test_a_plan_comes_back_from_a_recording_and_one_of_version_0_1_with_its_settings() -> None:
    plan = Plan(frames=7, image_size=32, scheme=FourierHadamardSettings(fourier_cycles=3, shuffle_seed=4))
    assert Plan.from_json(plan.model_dump_json()) == plan
    once = json.loads(plan.model_dump_json())
    settings = once["scheme"]
    keys = ("upsampling", "fourier_cycles", "hadamard_order", "shuffle_seed")  # all that version 0.1 had
    once.update({**{key: settings[key] for key in keys}, "scheme": "fourier-hadamard"})
    assert Plan.from_json(json.dumps(once)) == plan
