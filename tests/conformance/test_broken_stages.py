"""A suite that nothing can fail proves nothing: stages with one mistake each, and the test that finds it."""

from collections.abc import Callable
from inspect import signature
from threading import Lock
from typing import Any

import pytest

from protocols import Motion, MotionProfile, StagePosition, TravelExceeded
from protocols.conformance import stage as suite
from protocols.conformance.spot import Spot
from sim_backends.bench import OpticalBench
from sim_backends.devices.stage import SimulatedMotion, SimulatedStage, StageSettings
from tests.conformance.biting import FOUND, call
from tests.conformance.rigs import stage_rig


class ClipsTargets(SimulatedStage):
    def check(self, target_mm: float, profile: MotionProfile) -> None:
        pass

    def move_to(self, target_mm: float, profile: MotionProfile) -> SimulatedMotion:
        low, high = self.limits.travel_mm
        return super().move_to(min(max(target_mm, low), high), profile)


class ForgetsSigns(SimulatedStage):
    def move_by(self, distance_mm: float, profile: MotionProfile) -> SimulatedMotion:
        return super().move_by(abs(distance_mm), profile)


class TellsTheCommandedPosition(SimulatedStage):
    def position(self) -> StagePosition:
        position = super().position()
        return position.model_copy(update={"reported_mm": position.commanded_mm})


class GuessesInSecret(SimulatedStage):
    """Tells a position that lags behind the carriage, and does not mark it as a prediction."""

    def position(self) -> StagePosition:
        position = super().position()
        return position.model_copy(update={"reported_mm": position.reported_mm - 0.1})


class IgnoresStops(SimulatedStage):
    def cut(self, motion: SimulatedMotion) -> None:
        pass


class MovesOnAfterClosing(SimulatedStage):
    def __exit__(self, *exc: object) -> None:
        pass


class TakesASecondMove(SimulatedStage):
    def move_to(self, target_mm: float, profile: MotionProfile) -> SimulatedMotion:
        self.check(target_mm, profile)
        self.stop()
        return super().move_to(target_mm, profile)


class SwallowsErrors(SimulatedStage):
    def __exit__(self, *exc: object) -> bool:  # type: ignore[override]  # the mistake
        super().__exit__(*exc)
        return True


class HomesWhenOpened(SimulatedStage):
    def __init__(self, settings: StageSettings, bench: OpticalBench) -> None:
        super().__init__(settings, bench)
        self.home()


class WaitsBySleeping(SimulatedStage):
    """A sound one, but one that waits as a real driver does."""

    def move_by(self, distance_mm: float, profile: MotionProfile) -> Any:
        return _PolledMotion(self, super().move_by(distance_mm, profile), Lock())


class StopsBehindTheMove(WaitsBySleeping):
    """One lock for everything, held while a motion is waited for."""

    def __init__(self, settings: StageSettings, bench: OpticalBench) -> None:
        super().__init__(settings, bench)
        self._everything = Lock()

    def stop(self) -> None:
        if not self._everything.acquire(timeout=0.05):
            raise TimeoutError("a real one would wait for ever")
        self._everything.release()
        super().stop()

    def move_by(self, distance_mm: float, profile: MotionProfile) -> Any:
        return _PolledMotion(self, SimulatedStage.move_by(self, distance_mm, profile), self._everything)


class _PolledMotion:
    def __init__(self, stage: SimulatedStage, motion: Motion, held: Lock) -> None:
        self._stage, self._motion, self._held = stage, motion, held

    def wait(self, timeout_s: float | None = None) -> StagePosition:
        with self._held:
            while not self._motion.done:
                self._stage.clock.sleep_s(0.01)
        return self._motion.wait(timeout_s)


class BelievesInItsStop(SimulatedStage):
    @property
    def stands_by_s(self) -> float:
        return min(super().stands_by_s, self._motion.move.end_s)


class PromisesTooMuch(SimulatedStage):
    @property
    def stands_by_s(self) -> float:
        return self.clock.now_s()


class AlwaysDone(SimulatedStage):
    def move_by(self, distance_mm: float, profile: MotionProfile) -> Any:
        motion = super().move_by(distance_mm, profile)
        motion.wait()
        return motion


@pytest.mark.parametrize(
    ("broken", "test"),
    [
        (ClipsTargets, suite.test_what_is_outside_the_limits_is_refused_before_anything_moves),
        (ForgetsSigns, suite.test_relative_moves_are_signed_and_add_up),
        (TellsTheCommandedPosition, suite.test_the_position_in_motion_lies_between_start_and_target),
        (GuessesInSecret, suite.test_the_position_in_motion_lies_between_start_and_target),
        (IgnoresStops, suite.test_a_stop_from_another_thread_stops_the_stage_before_its_target),
        (IgnoresStops, suite.test_leaving_stops_the_stage),
        (MovesOnAfterClosing, suite.test_leaving_stops_the_stage),
        (TakesASecondMove, suite.test_a_second_move_is_refused_and_the_first_goes_on),
        (SwallowsErrors, suite.test_leaving_hides_no_error),
        (HomesWhenOpened, suite.test_nothing_is_homed_unless_it_is_asked_for),
        (StopsBehindTheMove, suite.test_a_stop_reaches_the_stage_while_another_thread_waits),
        (BelievesInItsStop, suite.test_it_tells_by_when_it_stands_even_if_no_stop_is_obeyed),
        (PromisesTooMuch, suite.test_it_tells_by_when_it_stands_even_if_no_stop_is_obeyed),
        (AlwaysDone, suite.test_a_move_returns_at_once_and_is_done_when_the_stage_stands),
    ],
)
def test_a_broken_stage_is_found(
    broken: type[SimulatedStage], test: Callable[..., None], monkeypatch: pytest.MonkeyPatch
) -> None:
    sound = broken.__base__
    assert sound is not None
    _try(sound, test, monkeypatch)
    with pytest.raises((*FOUND, TimeoutError)):
        _try(broken, test, monkeypatch)


def _try(kind: type[SimulatedStage], test: Callable[..., None], monkeypatch: pytest.MonkeyPatch) -> None:
    with stage_rig(kind) as rig:
        if "stage" not in signature(test).parameters:
            call(test, rig=rig)
            return
        with rig.open() as stage:
            spot = Spot(stage, rig)
            too_far = {"asked": _too_far, "error": TravelExceeded}
            call(test, rig=rig, stage=stage, spot=spot, sign=-1, by="stage", monkeypatch=monkeypatch, **too_far)


def _too_far(spot: Spot) -> tuple[float, MotionProfile]:
    return spot.travel_mm[1] + 1, spot.profile
