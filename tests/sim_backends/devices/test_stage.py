"""The simulated stage: trapezoids, limits, and a stop that never waits."""

import numpy as np
import pytest
from pydantic import ValidationError

from protocols import (
    BenchContext,
    DeviceBusy,
    DeviceError,
    DeviceTimeout,
    LinearStage,
    Motion,
    MotionProfile,
    MotionTooFast,
    TravelExceeded,
    WrongState,
)
from sim_backends.bench import OpticalBench, SceneSettings
from sim_backends.devices.stage import SimulatedStage, StageSettings, plugin
from tests.sim_backends.projector import all_on, bench_with, show

PROFILE = MotionProfile(velocity_mm_s=25.0, acceleration_mm_s2=50.0)


def stage_on_bench(**settings: object) -> tuple[SimulatedStage, OpticalBench]:
    bench = OpticalBench(SceneSettings())
    context = BenchContext(clock=bench.clock, scene=bench)
    return plugin.open(StageSettings.model_validate(settings), context), bench


def test_it_is_a_stage_that_says_it_is_simulated() -> None:
    stage, _ = stage_on_bench()
    assert isinstance(stage, LinearStage)
    assert stage.identity.name == "stage"
    assert stage.identity.simulated
    assert stage.homed


@pytest.mark.parametrize(
    ("distance_mm", "duration_s"),
    [(0.1, 0.0894), (1, 0.2828), (5, 0.6325), (10, 0.8944), (12.5, 1.0), (25, 1.5), (100, 4.5), (400, 16.5)],
)
def test_a_move_takes_the_time_of_its_trapezoid(distance_mm: float, duration_s: float) -> None:
    """The table of durations at 25 mm/s and 50 mm/s^2 in the stage's fact sheet, 5.1."""
    stage, bench = stage_on_bench()
    motion = stage.move_to(distance_mm, PROFILE)
    assert isinstance(motion, Motion)
    assert motion.target_mm == distance_mm
    position = motion.wait()
    assert bench.clock.now_s() == pytest.approx(duration_s, abs=5e-5)
    assert position.reported_mm == pytest.approx(distance_mm)
    assert motion.done


def test_during_a_move_the_position_is_that_of_the_profile() -> None:
    """Ramp 0.5 s and 6.25 mm, then 25 mm/s."""
    stage, bench = stage_on_bench()
    stage.move_to(25.0, PROFILE)
    for moment_s, position_mm in ((0.25, 1.5625), (0.5, 6.25), (0.75, 12.5), (1.0, 18.75), (1.5, 25.0)):
        bench.clock.advance_to(moment_s)
        position = stage.position()
        assert position.reported_mm == pytest.approx(position_mm, abs=0.00126)  # half a step of 2.5 um
        assert (position.time_s, position.commanded_mm, position.predicted) == (moment_s, 25.0, False)


def test_the_stage_carries_the_object() -> None:
    bench = bench_with(px_per_mm=2.0, axis_angle_deg=90.0)
    stage = plugin.open(StageSettings(position_mm=100.0), BenchContext(clock=bench.clock, scene=bench))
    stage.move_by(25.0, PROFILE)
    show(bench, [all_on()])
    shift_px = bench.truth(np.array([0.0, 0.5, 1.0, 9.0])).displacement_px
    assert shift_px[:, 1].tolist() == pytest.approx([0.0, 12.5, 37.5, 50.0])
    assert shift_px[:, 0].tolist() == pytest.approx([0.0] * 4)


def test_targets_are_whole_steps() -> None:
    stage, _ = stage_on_bench()
    assert stage.move_to(1.00124, PROFILE).target_mm == pytest.approx(1.0)
    stage.stop()
    assert stage.move_to(1.00126, PROFILE).target_mm == pytest.approx(1.0025)


def test_a_relative_move_is_signed() -> None:
    stage, _ = stage_on_bench(position_mm=10.0)
    assert stage.move_by(-2.5, PROFILE).wait().reported_mm == pytest.approx(7.5)


@pytest.mark.parametrize("target_mm", [-0.001, 400.001, float("nan")])
def test_a_target_outside_the_travel_is_refused_and_nothing_moves(target_mm: float) -> None:
    stage, _ = stage_on_bench()
    with pytest.raises(TravelExceeded, match="0 to 400 mm"):
        stage.check(target_mm, PROFILE)
    with pytest.raises(TravelExceeded):
        stage.move_to(target_mm, PROFILE)
    assert stage.position().commanded_mm == 0.0


@pytest.mark.parametrize(
    ("profile", "words"),
    [
        (MotionProfile(velocity_mm_s=51, acceleration_mm_s2=50), "velocity of 51 mm/s"),
        (MotionProfile(velocity_mm_s=25, acceleration_mm_s2=201), "acceleration of 201 mm/s"),
        (MotionProfile(velocity_mm_s=25, acceleration_mm_s2=50, initial_velocity_mm_s=26), "initial velocity of 26"),
    ],
)
def test_a_profile_beyond_the_limits_is_refused(profile: MotionProfile, words: str) -> None:
    stage, _ = stage_on_bench()
    with pytest.raises(MotionTooFast, match=words):
        stage.move_to(10.0, profile)
    assert stage.position().commanded_mm == 0.0


def test_a_second_move_is_refused_while_one_is_under_way() -> None:
    stage, bench = stage_on_bench()
    stage.move_to(10.0, PROFILE)
    with pytest.raises(DeviceBusy, match="on its way to 10 mm"):
        stage.move_by(1.0, PROFILE)
    with pytest.raises(DeviceBusy):
        stage.home()
    bench.clock.sleep_s(1.0)
    stage.move_to(0.0, PROFILE)


def test_a_wait_that_is_too_short_says_how_far_the_stage_has_come() -> None:
    stage, _ = stage_on_bench()
    with pytest.raises(DeviceTimeout, match=r"6\.250 of 25\.000 mm after 0\.5 s"):
        stage.move_to(25.0, PROFILE).wait(0.5)


def test_a_stop_is_immediate_and_the_waiter_is_told() -> None:
    stage, bench = stage_on_bench()
    motion = stage.move_to(25.0, PROFILE)
    bench.clock.advance_to(0.75)
    stage.stop()
    stage.stop()
    assert motion.done
    assert stage.position().reported_mm == 12.5
    with pytest.raises(DeviceError, match=r"stopped at 12\.500 mm; expected 25\.000 mm"):
        motion.wait()
    bench.clock.sleep_s(5.0)
    assert stage.position().reported_mm == 12.5
    stage.move_to(0.0, PROFILE).wait()
    assert stage.position().reported_mm == 0.0


def test_an_old_handle_does_not_stop_a_new_motion() -> None:
    stage, _ = stage_on_bench()
    old = stage.move_to(1.0, PROFILE)
    old.wait()
    new = stage.move_to(2.0, PROFILE)
    old.stop()
    assert new.wait().reported_mm == pytest.approx(2.0)


def test_homing_makes_the_position_true() -> None:
    stage, bench = stage_on_bench(homed=False, position_mm=10.0)
    motion = stage.home()
    before = stage.homed
    motion.wait()
    assert (before, stage.homed) == (False, True)
    assert stage.position().reported_mm == 0.0
    assert bench.clock.now_s() == pytest.approx(0.65)  # 25 mm/s and 100 mm/s^2 over 10 mm


def test_homing_that_was_stopped_leaves_the_origin_unknown() -> None:
    stage, bench = stage_on_bench(homed=False, position_mm=10.0)
    motion = stage.home()
    bench.clock.sleep_s(0.1)
    motion.stop()
    assert not stage.homed


def test_leaving_it_stops_and_closes_it() -> None:
    stage, bench = stage_on_bench()
    with stage:
        stage.move_to(25.0, PROFILE)
        bench.clock.advance_to(0.5)
    bench.clock.sleep_s(5.0)
    assert stage.position().reported_mm == 6.25
    with pytest.raises(WrongState, match="after the device was closed"):
        stage.move_to(1.0, PROFILE)


def test_a_stage_cannot_be_opened_outside_its_travel() -> None:
    with pytest.raises(ValidationError, match="position_mm = 500 is outside"):
        StageSettings(position_mm=500.0)
