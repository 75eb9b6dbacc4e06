"""The numbers of ka400z.md 5.1 and 2, and paths against the framework's own profile."""

import hypothesis.strategies as st
import numpy as np
import pytest
from hypothesis import given

from protocols import MotionProfile
from sim_backends.wire.stepper.axis import Axis
from sim_backends.wire.stepper.motion import Cut, Leg, Path, Rates, Trapezoid, cut_at
from sim_backends.wire.zolix import Mc600Settings


@pytest.mark.parametrize(
    ("distance_mm", "duration_s", "peak_mm_s"),
    [
        (0.1, 0.0894, 2.236),
        (1, 0.2828, 7.071),
        (5, 0.6325, 15.81),
        (10, 0.8944, 22.36),
        (12.5, 1.000, 25),
        (25, 1.500, 25),
        (50, 2.500, 25),
        (100, 4.500, 25),
        (200, 8.500, 25),
        (400, 16.500, 25),
    ],
)
def test_durations_and_peaks_are_those_of_the_table(distance_mm: float, duration_s: float, peak_mm_s: float) -> None:
    """25 mm/s, 50 mm/s^2, no initial speed."""
    move = Trapezoid(distance_mm, Rates(25, 0, 50))
    assert move.duration_s == pytest.approx(duration_s, abs=5e-5)
    assert move.speed(move.duration_s / 2) == pytest.approx(peak_mm_s, abs=5e-3)


@pytest.mark.parametrize(("distance_mm", "duration_s"), [(10, 0.800), (100, 4.405), (400, 16.405)])
def test_an_initial_speed_shortens_the_ramps(distance_mm: float, duration_s: float) -> None:
    """The sheet's values for v0 = 2.5 mm/s."""
    assert Trapezoid(distance_mm, Rates(25, 2.5, 50)).duration_s == pytest.approx(duration_s, abs=5e-4)


def test_cruise_lags_constant_velocity_by_6_25_mm() -> None:
    """v^2 / 2a = 6.25 mm, ramp time 0.5 s (5.1)."""
    travelled = Trapezoid(100, Rates(25, 0, 50)).travelled(np.array([0.5, 2.0]))
    np.testing.assert_allclose(travelled, [6.25, 2.0 * 25 - 6.25])


@given(
    distance=st.floats(-400, 400).filter(lambda asked: abs(asked) > 1e-3),
    velocity=st.floats(0.5, 50),
    initial=st.floats(0, 60),
    part=st.floats(-0.2, 1.2),
)
def test_a_move_is_that_of_the_framework(distance: float, velocity: float, initial: float, part: float) -> None:
    """Two implementations of the same formulas agree at any moment."""
    mine = Trapezoid(distance, Rates(velocity, initial, 50))
    profile = MotionProfile(velocity_mm_s=velocity, initial_velocity_mm_s=min(initial, velocity), acceleration_mm_s2=50)
    assert mine.duration_s == pytest.approx(profile.duration_s(distance), rel=1e-9)
    elapsed_s = part * mine.duration_s
    travelled = float(mine.travelled(np.array([elapsed_s]))[0])
    assert travelled == pytest.approx(profile.travelled_mm(distance, elapsed_s), abs=1e-8)


def test_a_lead_of_4_mm_gives_400_pulses_a_millimetre() -> None:
    """The table of section 2, 8 microsteps; 320 for a lead of 5 mm."""
    assert Mc600Settings(lead_mm=4).pulses_per_mm == 400
    assert Mc600Settings(lead_mm=5).pulses_per_mm == 320


def test_a_stop_from_cruise_takes_half_a_second_and_6_25_mm() -> None:
    """25 mm/s down at 50 mm/s^2, in pulses of 2.5 um."""
    axis = Axis(low=-200_000, high=200_000, start=0)
    rates = Rates(10_000, 0, 20_000)
    axis.move(0.0, 40_000, rates)
    axis.stop(2.0, rates, decelerate=True)
    assert axis.end_s == pytest.approx(2.5)
    assert axis.reported(9.0) == (2 * 25 - 6.25 + 6.25) * 400 == axis.target


def test_an_abrupt_stop_stands_at_once() -> None:
    """No further way."""
    axis = Axis(low=-200_000, high=200_000, start=0)
    axis.move(0.0, 40_000, Rates(10_000, 0, 20_000))
    axis.stop(2.0, Rates(10_000, 0, 20_000), decelerate=False)
    assert (axis.end_s, axis.reported(9.0)) == (2.0, 17_500)


def test_a_limit_switch_ends_a_move_and_lets_go_only_the_other_way() -> None:
    """3E: abrupt stop at the limit, then motion only away from it."""
    axis = Axis(low=-100, high=1000, start=0)
    axis.move(0.0, 5000, Rates(1000, 0, 1000))
    assert axis.reported(10.0) == 1000
    assert axis.end_s == pytest.approx(1.5)
    assert (axis.blocked(10.0, 1), axis.blocked(10.0, -1)) == (True, False)
    stuck = Axis(low=-100, high=1000, start=1000, limit_sticks=True)
    assert stuck.blocked(0.0, -1)


def test_a_stalled_motor_stands_while_the_counter_goes_on() -> None:
    """Half of 1000 pulses are done, all of them are counted."""
    axis = Axis(low=-10_000, high=10_000, start=0)
    axis.move(0.0, 1000, Rates(1000, 0, 1000), stall_at=0.5)
    assert (axis.reported(9.0), axis.carriage.now(9.0)) == (1000, 500)
    axis.move(10.0, -1000, Rates(1000, 0, 1000))
    assert (axis.reported(19.0), axis.carriage.now(19.0)) == (0, -500)


def test_a_nut_with_play_loses_way_at_each_reversal() -> None:
    """8 pulses of play: up 100 is 100, down 5 is nothing, down 50 more is 47, up 8 is nothing, up 1 more is 1."""
    axis = Axis(low=-10_000, high=10_000, start=0, backlash=8)
    stands: list[float] = []
    for number, distance in enumerate((100, -5, -50, 8, 1)):
        axis.move(10.0 * number, distance, Rates(1000, 0, 1000))
        stands.append(axis.carriage.now(10.0 * number + 9))
    assert stands == [100, 100, 53, 53, 54]
    assert axis.reported(99.0) == 54


def test_a_stop_inside_the_play_moves_nothing() -> None:
    """Two pulses a second are stopped after 8 of 20 pulses of play; the next move has the rest to take up."""
    axis = Axis(low=-10_000, high=10_000, start=0, backlash=20)
    axis.move(0.0, -100, Rates(2, 2, 1000))
    axis.stop(4.0, Rates(2, 2, 1000), decelerate=True)
    assert (axis.reported(5.0), axis.carriage.now(5.0)) == (-8, 0)
    axis.move(10.0, -13, Rates(2, 2, 1000))
    assert (axis.reported(30.0), axis.carriage.now(30.0)) == (-21, -1)


@given(ways=st.lists(st.integers(-50, 50).filter(bool), max_size=12), backlash=st.integers(0, 30))
def test_the_carriage_stays_within_the_play_behind_the_counter(ways: list[int], backlash: int) -> None:
    """The play operator: after each move the carriage is the old place, pulled into [counter, counter + play]."""
    axis, place, counter = Axis(low=-10_000, high=10_000, start=0, backlash=backlash), 0, 0
    for number, way in enumerate(ways):
        axis.move(10.0 * number, way, Rates(1000, 10, 1000))
        counter += way
        place = min(max(place, counter), counter + backlash)
        assert (axis.reported(10.0 * number + 9), axis.carriage.now(10.0 * number + 9)) == (counter, place)


@pytest.mark.parametrize(("direction", "way"), [("direct", 300), ("negative", 1300 + 1000), ("positive", 1700 + 2000)])
def test_homing_ends_with_carriage_and_counter_at_zero(direction: str, way: int) -> None:
    """From 300, with limits at -1000 and 2000, at 100 pulses a second without ramps."""
    axis = Axis(low=-1000, high=2000, start=300)
    axis.home(5.0, Rates(100, 100, 1e6), direction, None)  # type: ignore[arg-type]
    assert axis.end_s - 5.0 == pytest.approx(way / 100)
    assert (axis.reported(axis.end_s), axis.carriage.now(axis.end_s), axis.homed) == (0, 0, True)
    timed = Axis(low=-1000, high=2000, start=300)
    timed.home(5.0, Rates(100, 100, 1e6), direction, 7.0)  # type: ignore[arg-type]
    assert timed.end_s == pytest.approx(12.0)


def test_a_homing_that_was_stopped_has_not_homed() -> None:
    """The counter keeps its old meaning."""
    axis = Axis(low=-1000, high=1000, start=300)
    axis.home(0.0, Rates(100, 100, 100), "direct", None)
    axis.stop(1.0, Rates(100, 100, 100), decelerate=True)
    assert (axis.homed, axis.reported(9.0), axis.carriage.now(9.0)) == (False, -100, 200)


@given(distance=st.floats(0.01, 99.9))
def test_a_cut_motion_has_gone_just_so_far(distance: float) -> None:
    """Bisection finds the moment for any distance."""
    cut = cut_at(Trapezoid(-100, Rates(25, 1, 50)), distance)
    assert isinstance(cut, Cut)
    assert float(cut.travelled(np.array([1e9]))[0]) == pytest.approx(-distance, abs=1e-6)


def test_a_path_forgets_what_an_interruption_cancels() -> None:
    """A leg from 1 s on replaces what was to begin at 2 s."""
    path = Path((Leg(0.0, 1.0), Leg(2.0, 5.0))).then(Leg(1.0, 3.0))
    np.testing.assert_array_equal(path.at(np.array([-1.0, 0.5, 1.0, 2.5])), [1, 1, 3, 3])
