"""The suite on a stage that keeps its position from test to test, as every real one does: it is never far away, and comes back.

The stages of ``test_stages.py`` are new for each test. On one that is not, the suite once walked from 50 to 99.4 mm of 100.
"""

import sys
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from typing import Any

import pytest

from protocols import MonotonicClock, StageLimits
from protocols.conformance import RigFactory, StageRig
from protocols.conformance.consent import ask_before_moving
from protocols.conformance.spot import Spot, brought_back
from protocols.conformance.stage import *  # noqa: F403
from tests.conformance.rigs import simulated_stage

SPAN_MM = (195.0, 201.0)
"""Of 400 mm of travel. The stage begins at 200 mm, which is nearer to one end."""


@dataclass
class Kept:
    """One stage for all tests, and how far it has been."""

    rig: StageRig
    seen_mm: list[float]

    def look(self) -> None:
        """Note where the carriage is."""
        assert self.rig.carriage_mm is not None
        self.seen_mm.append(self.rig.carriage_mm())


class WatchedClock:
    """The rig's clock, which looks at the carriage whenever time passes: ten times in each wait."""

    def __init__(self, clock: Any) -> None:
        self._clock = clock
        self.kept: Kept | None = None

    def now_s(self) -> float:
        return float(self._clock.now_s())

    def sleep_s(self, duration_s: float) -> None:
        for _ in range(10):
            self._clock.sleep_s(duration_s / 10)
            if self.kept is not None:
                self.kept.look()


@pytest.fixture(scope="module")
def kept() -> Iterator[Kept]:
    with simulated_stage() as rig:
        with rig.open() as stage:
            stage.move_to(200.0, Spot(stage, rig).profile).wait()
        clock = WatchedClock(rig.clock)
        kept = Kept(replace(rig, clock=clock, span_mm=SPAN_MM, may_home=False), [])
        clock.kept = kept
        yield kept
        assert rig.carriage_mm is not None
        assert rig.carriage_mm() == pytest.approx(200.0, abs=rig.tolerance_mm)
        assert min(kept.seen_mm) >= SPAN_MM[0] - rig.tolerance_mm
        assert max(kept.seen_mm) <= SPAN_MM[1] + rig.tolerance_mm


@pytest.fixture
def open_rig(kept: Kept) -> RigFactory[StageRig]:
    @contextmanager
    def the_same() -> Generator[StageRig]:
        yield kept.rig

    return the_same


# Before anything real moves


def real(rig: StageRig, serial: str = "") -> StageRig:
    """The same rig on the host's clock, with a stage that does not say that it is simulated."""

    def opened() -> Any:
        stage = rig.open()
        identity = stage.identity.model_copy(update={"simulated": False, "serial": serial})
        monkey = type("Real", (type(stage),), {"identity": identity})
        stage.__class__ = monkey
        return stage

    return replace(rig, clock=MonotonicClock(), open=opened)


class Terminal:
    """A person who answers."""

    def __init__(self, answer: str) -> None:
        self._answer = answer

    def isatty(self) -> bool:
        return True

    def readline(self) -> str:
        return self._answer


@pytest.mark.parametrize("person", [None, Terminal("n\n"), Terminal("\n")])
def test_a_real_stage_is_not_moved_before_somebody_agrees(
    person: Terminal | None, pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(sys, "__stdin__", person)
    with simulated_stage() as rig:
        ask_before_moving(rig, pytestconfig)
        stands_mm = rig.carriage_mm and rig.carriage_mm()
        with pytest.raises(
            pytest.fail.Exception, match=r"between .* mm, at 5 mm/s, and to its origin.*--kinopix-may-move"
        ):
            ask_before_moving(real(rig), pytestconfig)
        assert stands_mm == (rig.carriage_mm and rig.carriage_mm())


def test_who_has_agreed_is_not_asked_again(pytestconfig: pytest.Config, monkeypatch: pytest.MonkeyPatch) -> None:
    with simulated_stage() as rig:
        monkeypatch.setattr(sys, "__stdin__", Terminal("y\n"))
        ask_before_moving(real(rig, "agreed"), pytestconfig)
        monkeypatch.setattr(sys, "__stdin__", None)
        ask_before_moving(real(rig, "agreed"), pytestconfig)
        with pytest.raises(pytest.fail.Exception, match="Nobody has agreed"):
            ask_before_moving(real(rig, "another"), pytestconfig)


def test_a_stage_outside_its_span_is_not_moved(pytestconfig: pytest.Config) -> None:
    told = r"stands at .* mm, and the rig's span_mm is 300 to 310 mm"
    with simulated_stage() as rig, pytest.raises(AssertionError, match=told):
        ask_before_moving(replace(rig, span_mm=(300.0, 310.0)), pytestconfig)


def test_a_stage_is_brought_back_after_a_test_that_fails_in_motion() -> None:
    with simulated_stage() as rig:
        assert rig.carriage_mm is not None
        begun_mm = rig.carriage_mm()

        def fails() -> None:
            with brought_back(rig) as lent, lent.open() as stage:
                spot = Spot(stage, lent)
                stage.move_by(spot.reach_mm, spot.profile)
                rig.clock.sleep_s(0.5)
                raise ZeroDivisionError

        with pytest.raises(ZeroDivisionError):
            fails()
        assert rig.carriage_mm() == pytest.approx(begun_mm, abs=rig.tolerance_mm)


@pytest.mark.parametrize(
    ("here_mm", "span_mm", "middle_mm", "reach_mm"),
    [
        (50.0, None, 50.0, 5.4),
        (1.0, None, 6.0, 5.4),
        (50.04, None, 50.0, 5.4),
        (50.0, (48.0, 52.0), 50.0, 1.8),
        (51.0, (48.0, 52.0), 50.0, 1.8),
        (50.0, (0.0, 60.0), 50.0, 5.4),
        (58.0, (0.0, 60.0), 54.0, 5.4),
    ],
)
def test_a_spot_is_where_the_stage_stood_with_room_on_both_sides(
    here_mm: float, span_mm: tuple[float, float] | None, middle_mm: float, reach_mm: float
) -> None:
    """Of 100 mm of travel: 6 mm to both sides, of which tests use 90 %."""

    class Stage:
        limits = StageLimits(travel_mm=(0.0, 100.0), max_velocity_mm_s=20, max_acceleration_mm_s2=100)

    rig = StageRig(open=Stage, clock=MonotonicClock(), span_mm=span_mm, begun_mm=here_mm)  # type: ignore[arg-type]
    spot = Spot(Stage(), rig)  # type: ignore[arg-type]
    assert (spot.middle_mm, spot.reach_mm) == pytest.approx((middle_mm, reach_mm))
