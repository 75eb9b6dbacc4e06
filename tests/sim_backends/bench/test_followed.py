"""A stage that does not know the bench carries the object by what it says of its position."""

from typing import Any

import numpy as np
import pytest

from protocols import DeviceTimeout, InputError, LinearStage, MotionProfile, StagePosition
from sim_backends.bench import OpticalBench, SceneSettings, VirtualClock
from sim_backends.bench.followed import FollowedStage
from sim_backends.devices.stage import SimulatedStage, StageSettings
from tests.sim_backends.projector import PICTURE_S, all_on, show

PROFILE = MotionProfile(velocity_mm_s=25.0, acceleration_mm_s2=50.0)


class Elsewhere(OpticalBench):
    """Another bench that keeps the time of a first one: what stands on it is a stranger to the first."""

    def __init__(self, clock: VirtualClock) -> None:
        super().__init__(SceneSettings())
        self._clock = clock


def stranger(bench: OpticalBench, kind: type[SimulatedStage] = SimulatedStage, **settings: Any) -> SimulatedStage:
    assert isinstance(bench.clock, VirtualClock)
    return kind(StageSettings(**settings), Elsewhere(bench.clock))


def displacement_px(bench: OpticalBench, stage: LinearStage) -> Any:
    """Of 400 pictures at cruise velocity, asked for in steps of 20 ms."""
    stage.move_to(stage.position().reported_mm + 40.0, PROFILE)
    bench.clock.sleep_s(0.6)
    show(bench, [all_on()] * 400, start_s=bench.clock.now_s() + 0.001)
    for _ in range(3):
        bench.clock.sleep_s(0.02)
        bench.edges(0, bench.clock.now_s())
    return bench.truth(np.arange(400, dtype=np.float64) * np.float64(PICTURE_S)).displacement_px


def test_a_stranger_carries_the_object_as_a_stage_of_the_bench_does() -> None:
    """25 mm/s for 20 ms are 0.5 mm; at 7.2 px/mm along an axis at 45 degrees 2.5 px each way."""
    own, other = OpticalBench(SceneSettings()), OpticalBench(SceneSettings())
    stage = SimulatedStage(StageSettings(), own)
    assert own.carried_by(stage) is stage
    followed = other.carried_by(stranger(other))
    assert isinstance(followed, LinearStage)
    ours, theirs = displacement_px(own, stage), displacement_px(other, followed)
    assert np.hypot(*ours[-1]) == pytest.approx(7.2 * 25 * 0.01995, rel=1e-3)
    np.testing.assert_allclose(theirs, ours, atol=1e-3)


def test_in_a_ramp_the_object_is_within_a_t_squared_by_8_of_the_stage() -> None:
    """Looks 20 ms apart at 50 mm/s^2: 2.5 um."""
    bench = OpticalBench(SceneSettings())
    stage = stranger(bench)
    followed = FollowedStage(stage, bench.clock)
    start_mm = stage.position().reported_mm
    followed.move_to(start_mm + 40.0, PROFILE)
    for _ in range(10):
        bench.clock.sleep_s(0.02)
        followed.look()
    time_s = np.linspace(0.0, 0.2, 101)
    true_mm = start_mm + np.array([PROFILE.travelled_mm(40.0, t) for t in time_s])
    worst_mm = np.abs(followed.position_mm(time_s) - true_mm).max()
    assert worst_mm == pytest.approx(50 * 0.02**2 / 8, rel=0.02)
    assert followed.position_mm(np.array([0.22]))[0] - followed.position_mm(np.array([0.2]))[0] == pytest.approx(0.19)


def test_it_is_the_stage_in_all_else() -> None:
    bench = OpticalBench(SceneSettings())
    stage = stranger(bench)
    followed = bench.carried_by(stage)
    assert (followed.identity, followed.limits, followed.homed) == (stage.identity, stage.limits, stage.homed)
    motion = followed.move_by(5.0, PROFILE)
    assert followed.stands_by_s == stage.stands_by_s
    followed.stop()
    assert motion.done
    end = followed.move_to(10.0, PROFILE).wait()
    assert end.reported_mm == followed.position().reported_mm == 10.0
    assert followed.home().wait().reported_mm == 0.0


class OtherTime(SimulatedStage):
    """Stamps its positions by a clock of its own."""

    def position(self) -> StagePosition:
        here = super().position()
        return here.model_copy(update={"time_s": here.time_s + 1000.0})


class InRealTime(SimulatedStage):
    """Moves in a time of its own: after all that virtual time it has hardly moved."""

    def move_to(self, target_mm: float, profile: MotionProfile) -> Any:
        slow = MotionProfile(velocity_mm_s=profile.velocity_mm_s / 1000, acceleration_mm_s2=profile.acceleration_mm_s2)
        motion = super().move_to(target_mm, slow)
        usual_s = 1.2 * profile.duration_s(target_mm) + 1
        wait = motion.wait
        motion.wait = lambda timeout_s=None: wait(usual_s if timeout_s is None else timeout_s)  # type: ignore[method-assign]
        return motion


def test_a_stage_with_a_clock_of_its_own_is_refused_with_the_way_out() -> None:
    bench = OpticalBench(SceneSettings())
    with pytest.raises(InputError, match=r"virtual.*set realtime = true in \[scene\]"):
        bench.carried_by(stranger(bench, OtherTime))


def test_a_stage_that_moves_in_real_time_is_told_instead_of_being_late() -> None:
    bench = OpticalBench(SceneSettings())
    followed = bench.carried_by(stranger(bench, InRealTime))
    motion = followed.move_to(50.0, PROFILE)
    with pytest.raises(DeviceTimeout):
        motion.wait(0.1)  # who sets a limit of his own gets what he asked for
    with pytest.raises(InputError, match=r"of which .* s were real time.*set realtime = true in \[scene\]"):
        motion.wait()
