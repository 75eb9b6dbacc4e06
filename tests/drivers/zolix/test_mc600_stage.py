"""The driver on an MC600: bytes sent, bytes answered, nothing left over."""

import pytest

from protocols import (
    DeviceBusy,
    LinearStage,
    Motion,
    MotionProfile,
    MotionTooFast,
    PlanError,
    TravelExceeded,
    WrongState,
)
from tests.drivers.zolix.mc600 import AT_ZERO, SPEEDS, stage_on
from tests.drivers.zolix.scripted import PROFILE, After, Line


def test_opening_asks_ve_then_hello_then_the_position_and_sets_the_unit_to_pulses() -> None:
    """The probe order of the sheet; a fence; the unit; a first position told twice."""
    stage, port, _ = stage_on()
    assert port.nothing_left_over()
    assert isinstance(stage, LinearStage)
    assert stage.identity.model == "KA400Z on MC600"
    assert stage.identity.simulated
    assert port.timeout == 0


def test_an_absolute_move_sets_the_speeds_goes_and_reads_the_position_back() -> None:
    """1000 pulses at 400 a millimetre are 2.5 mm; READY at once, the position line at the end."""
    stage, port, clock = stage_on(
        AT_ZERO,
        *SPEEDS,
        (b"GoPosition X,O,A,P,1000\r", b"READY\r", After(0.45, b"X 1000.0,OK\r")),
        (b"Position? X\r", b"POSITION? X,1000.0,OK\r"),
    )
    motion = stage.move_to(2.5, PROFILE)
    assert isinstance(motion, Motion)
    assert not motion.done
    arrived = motion.wait()
    assert (arrived.commanded_mm, arrived.reported_mm, arrived.predicted) == (2.5, 2.5, False)
    assert clock.time_s < 1
    assert port.nothing_left_over()


def test_speeds_are_sent_again_only_when_they_change() -> None:
    """The second move has another velocity, the third none; a negative relative move is N and unsigned."""
    at_1000: Line = (b"Position? X\r", b"POSITION? X,1000.0,OK\r")
    at_600: Line = (b"Position? X\r", b"POSITION? X,600.0,OK\r")
    stage, port, _ = stage_on(
        AT_ZERO,
        *SPEEDS,
        (b"GoPosition X,O,A,P,1000\r", b"READY\r", After(0.45, b"X 1000.0,OK\r")),
        at_1000,
        at_1000,
        (b"SetSpeed X,4000\r", b"OK\r"),
        (b"GoPosition X,O,R,N,400\r", b"READY\r", After(0.3, b"X 600.0,OK\r")),
        at_600,
        at_600,
        (b"GoPosition X,O,R,N,600\r", b"READY\r", After(0.4, b"X 0.0,OK\r")),
        AT_ZERO,
    )
    stage.move_to(2.5, PROFILE).wait()
    slower = MotionProfile(velocity_mm_s=10, acceleration_mm_s2=50)
    assert stage.move_by(-1.0, slower).wait().reported_mm == 1.5
    assert stage.move_by(-1.5, slower).wait().reported_mm == 0.0
    assert port.nothing_left_over()


def test_the_start_velocity_is_never_above_the_velocity_while_both_are_set() -> None:
    """Going up, the velocity is sent first where the new start velocity is above the old velocity."""
    stage, port, _ = stage_on(
        AT_ZERO,
        (b"SetAccSpeed X,20000\r", b"OK\r"),
        (b"SetInitSpeed X,400\r", b"OK\r"),
        (b"SetSpeed X,800\r", b"OK\r"),
        (b"GoPosition X,O,A,P,400\r", b"READY\r", After(0.5, b"X 400.0,OK\r")),
        (b"Position? X\r", b"POSITION? X,400.0,OK\r"),
        (b"Position? X\r", b"POSITION? X,400.0,OK\r"),
        (b"SetSpeed X,10000\r", b"OK\r"),
        (b"SetInitSpeed X,1000\r", b"OK\r"),
        (b"GoPosition X,O,A,P,0\r", b"READY\r", After(0.2, b"X 0.0,OK\r")),
        AT_ZERO,
        initial_velocity_mm_s=1.0,
    )
    stage.move_to(1.0, MotionProfile(velocity_mm_s=2, acceleration_mm_s2=50)).wait()
    fast = MotionProfile(velocity_mm_s=25, acceleration_mm_s2=50, initial_velocity_mm_s=2.5)
    stage.move_to(0.0, fast).wait()
    assert port.nothing_left_over()


def test_position_during_a_motion_is_the_controllers_own_at_the_middle_of_the_exchange() -> None:
    """Asked 12 mm into the move; stamped half-way between question and answer."""
    stage, port, clock = stage_on(
        AT_ZERO,
        *SPEEDS,
        (b"GoPosition X,O,A,P,40000\r", b"READY\r", After(4.5, b"X 40000.0,OK\r")),
        (b"Position? X\r", b"POSITION? X,4800.0,OK\r"),
    )
    stage.move_to(100, PROFILE)
    clock.sleep_s(0.05)  # the 20 ms of silence before a command are over
    asked_s = clock.time_s
    here = stage.position()
    assert (here.reported_mm, here.commanded_mm, here.predicted) == (12.0, 100.0, False)
    assert here.time_s == pytest.approx(asked_s + 0.005, abs=0.001)
    assert port.nothing_left_over()


def test_a_completion_line_is_not_taken_for_the_answer_to_a_query() -> None:
    """The end of the motion arrives between question and answer; both are understood."""
    stage, port, _ = stage_on(
        AT_ZERO,
        *SPEEDS,
        (b"GoPosition X,O,A,P,1000\r", b"READY\r"),
        (b"Position? X\r", b"X 1000.0,OK\rPOSITION? X,999.0,OK\r"),
        (b"Position? X\r", b"POSITION? X,1000.0,OK\r"),
    )
    motion = stage.move_to(2.5, PROFILE)
    assert stage.position().reported_mm == 999 / 400
    assert motion.wait().reported_mm == 2.5
    assert port.nothing_left_over()


def test_a_move_of_no_pulse_is_over_at_once_and_sends_no_motion_command() -> None:
    """0.001 mm is 0.4 pulses."""
    stage, port, _ = stage_on(AT_ZERO)
    motion = stage.move_by(0.001, PROFILE)
    assert motion.done
    assert motion.wait().reported_mm == 0.0
    assert port.nothing_left_over()


@pytest.mark.parametrize("target_mm", [-0.001, 400.001, float("nan"), float("inf")])
def test_a_target_outside_the_travel_is_refused_before_a_byte_is_sent(target_mm: float) -> None:
    """Limits are an error, never clipped."""
    stage, port, _ = stage_on()
    with pytest.raises(TravelExceeded, match="0 to 400 mm"):
        stage.move_to(target_mm, PROFILE)
    assert port.nothing_left_over()


@pytest.mark.parametrize(
    ("profile", "error"),
    [
        (MotionProfile(velocity_mm_s=40.1, acceleration_mm_s2=50), MotionTooFast),
        (MotionProfile(velocity_mm_s=25, acceleration_mm_s2=101), MotionTooFast),
        (MotionProfile(velocity_mm_s=1, acceleration_mm_s2=50, initial_velocity_mm_s=2), MotionTooFast),
        (MotionProfile(velocity_mm_s=0.001, acceleration_mm_s2=50), PlanError),
    ],
)
def test_a_profile_outside_the_limits_is_refused_before_a_byte_is_sent(
    profile: MotionProfile, error: type[PlanError]
) -> None:
    """Too fast, or slower than one pulse a second."""
    stage, port, _ = stage_on()
    with pytest.raises(error):
        stage.check(10, profile)
    with pytest.raises(error):
        stage.move_to(10, profile)
    assert port.nothing_left_over()


def test_a_second_move_is_refused_while_the_first_is_under_way() -> None:
    """Nothing is sent for it."""
    stage, port, _ = stage_on(AT_ZERO, *SPEEDS, (b"GoPosition X,O,A,P,1000\r", b"READY\r"))
    stage.move_to(2.5, PROFILE)
    with pytest.raises(DeviceBusy, match=r"2\.5 mm under way"):
        stage.move_to(5, PROFILE)
    with pytest.raises(DeviceBusy):
        stage.move_by(1, PROFILE)
    with pytest.raises(DeviceBusy):
        stage.home()
    assert port.nothing_left_over()


def test_homing_ends_with_any_line_with_ok_and_sets_homed() -> None:
    """The sheet has only "a line with OK" for the end of homing; two equal positions confirm it."""
    stage, port, _ = stage_on(
        AT_ZERO,
        (b"SetAccSpeed X,40000\r", b"OK\r"),
        (b"SetInitSpeed X,0\r", b"OK\r"),
        (b"SetSpeed X,2000\r", b"OK\r"),
        (b"SetHomeSpeed X,2000\r", b"OK\r"),
        (b"GoHome X\r", b"READY\r", After(2, b"OK\r")),
        (b"SetUnit? X\r", b"SETUNIT? X,s,OK\r"),
        AT_ZERO,
        AT_ZERO,
    )
    motion = stage.home()
    homed_on_the_way = stage.homed
    assert motion.wait().reported_mm == 0.0
    assert (homed_on_the_way, stage.homed) == (False, True)
    assert port.nothing_left_over()


def test_require_home_refuses_moves_of_a_stage_that_was_not_homed() -> None:
    """Only on request, because a controller cannot tell whether it has been homed."""
    stage, port, _ = stage_on(AT_ZERO, require_home=True)
    with pytest.raises(WrongState, match="homed"):
        stage.move_to(1, PROFILE)
    assert port.nothing_left_over()


def test_leaving_stops_the_stage_and_closes_the_port_once() -> None:
    """Twice is once."""
    stage, port, _ = stage_on((b"Stop X\r", b"OK\r"))
    with stage:
        pass
    stage.__exit__(None, None, None)
    stage.stop()
    assert port.closed
    assert port.nothing_left_over()
