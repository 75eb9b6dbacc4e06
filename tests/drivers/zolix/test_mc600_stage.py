"""The driver on an MC600: bytes sent, bytes answered, nothing left over."""

import pytest

from drivers.zolix.driver import Ka400z
from protocols import (
    DeviceBusy,
    DeviceDisconnected,
    DeviceError,
    DeviceRefused,
    DeviceTimeout,
    LinearStage,
    Motion,
    MotionProfile,
    MotionTooFast,
    PlanError,
    TravelExceeded,
    WrongState,
)
from tests.drivers.zolix.scripted import (
    MC600_OPENS,
    PROFILE,
    After,
    Line,
    ScriptedPort,
    VirtualClock,
    opened,
)

AT_ZERO: Line = (b"Position? X\r", b"POSITION? X,0.0,OK\r")
SPEEDS: tuple[Line, ...] = (
    (b"SetAccSpeed X,20000\r", b"OK\r"),
    (b"SetInitSpeed X,0\r", b"OK\r"),
    (b"SetSpeed X,10000\r", b"OK\r"),
)


def stage_on(*lines: Line, **changes: object) -> tuple[Ka400z, ScriptedPort, VirtualClock]:
    """Give a stage that has been opened and then plays ``lines``."""
    stage, port, clock = opened(MC600_OPENS, **changes)
    assert port.nothing_left_over()
    port.expect(*lines)
    return stage, port, clock


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


def test_a_controller_that_turns_out_to_be_mute_in_motion_is_predicted_from_then_on() -> None:
    """Asked once, without an answer; then not asked again."""
    stage, port, clock = stage_on(
        AT_ZERO,
        *SPEEDS,
        (b"GoPosition X,O,A,P,40000\r", b"READY\r", After(4.5, b"X 40000.0,OK\r")),
        (b"Position? X\r", b""),
    )
    stage.move_to(100, PROFILE)
    moving_since_s = clock.time_s  # READY was there some milliseconds ago
    clock.sleep_s(0.5)
    first, second = stage.position(), stage.position()
    assert first.predicted
    assert second.predicted
    # 25 mm/s after a ramp of 0.5 s and 6.25 mm
    assert second.reported_mm == pytest.approx(6.25 + 25 * (second.time_s - moving_since_s - 0.5), abs=0.5)
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


def test_stop_needs_no_answer_and_the_motion_ends_as_an_error_where_the_stage_stands() -> None:
    """Answer to the stop is unknown, so an OK is fenced off; the position is read twice before it is believed."""
    at_400: Line = (b"Position? X\r", b"POSITION? X,400.0,OK\r")
    stage, port, clock = stage_on(
        AT_ZERO,
        *SPEEDS,
        (b"GoPosition X,O,A,P,40000\r", b"READY\r"),
        (b"Stop X\r", b"OK\rX 400.0,OK\r"),
        (b"SetUnit? X\r", b"SETUNIT? X,s,OK\r"),
        at_400,
        at_400,
    )
    motion = stage.move_to(100, PROFILE)
    before_s = clock.time_s
    stage.stop()
    assert clock.time_s == before_s
    with pytest.raises(DeviceError, match=r"over at 1 mm, after a stop; expected 100 mm"):
        motion.wait()
    assert motion.done
    assert port.nothing_left_over()


def test_a_limit_switch_ends_the_motion_elsewhere_and_that_is_an_error() -> None:
    """The completion line names another place, the controller says it again twice."""
    at_limit: Line = (b"Position? X\r", b"POSITION? X,30000.0,OK\r")
    stage, port, _ = stage_on(
        AT_ZERO,
        *SPEEDS,
        (b"GoPosition X,O,A,P,40000\r", b"READY\r", After(3, b"X 30000.0,OK\r")),
        at_limit,
        at_limit,
    )
    with pytest.raises(DeviceError, match=r"over at 75 mm; expected 100 mm. To do: look at the limit switches"):
        stage.move_to(100, PROFILE).wait()
    assert port.nothing_left_over()


def test_an_old_completion_line_does_not_end_a_new_motion() -> None:
    """A doubled line arrives in the next move: two positions differ, so the stage still moves."""
    stage, port, _ = stage_on(
        AT_ZERO,
        *SPEEDS,
        (b"GoPosition X,O,A,P,40000\r", b"READY\r", After(0.1, b"X 0.0,OK\r"), After(4.5, b"X 40000.0,OK\r")),
        (b"Position? X\r", b"POSITION? X,120.0,OK\r"),
        (b"Position? X\r", b"POSITION? X,400.0,OK\r"),
        (b"Position? X\r", b"POSITION? X,40000.0,OK\r"),
    )
    assert stage.move_to(100, PROFILE).wait().reported_mm == 100
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


def test_a_refused_move_is_an_error_with_the_controllers_code() -> None:
    """E02 in place of READY; the stage is free for the next move."""
    stage, port, _ = stage_on(AT_ZERO, *SPEEDS, (b"GoPosition X,O,A,P,1000\r", b"E02\r"), AT_ZERO)
    with pytest.raises(DeviceRefused, match="code E02") as refused:
        stage.move_to(2.5, PROFILE)
    assert refused.value.code == "E02"
    assert stage.position().reported_mm == 0.0
    assert port.nothing_left_over()


def test_a_lost_answer_is_a_timeout_that_names_what_was_awaited_and_what_came() -> None:
    """Half an answer; 0.5 s margin plus (12 + 64) bytes of 10 bits at 19200 baud is 0.54 s."""
    stage, port, clock = stage_on((b"Position? X\r", b"POSITION? X,1"))
    clock.sleep_s(0.05)
    before_s = clock.time_s
    with pytest.raises(DeviceTimeout, match=r"only b'POSITION\? X,1' after 0.54 s; expected Position in answer to"):
        stage.position()
    assert clock.time_s - before_s == pytest.approx(0.54, abs=0.005)
    assert port.nothing_left_over()


def test_an_answer_that_comes_after_its_timeout_is_not_taken_for_the_next_one() -> None:
    """After a time-out the next exchange is fenced: what comes before the fence's answer is old."""
    stage, port, clock = stage_on(
        (b"Position? X\r", After(0.7, b"POSITION? X,77.0,OK\r")),
        (b"SetUnit? X\r", After(0.3, b"SETUNIT? X,s,OK\r")),
        AT_ZERO,
    )
    with pytest.raises(DeviceTimeout):
        stage.position()
    clock.sleep_s(0.1)
    assert stage.position().reported_mm == 0.0
    assert port.nothing_left_over()


def test_a_position_that_contradicts_what_is_known_is_asked_again() -> None:
    """A standing stage was at 0; 900 is one damaged digit, told once and not again."""
    stage, port, _ = stage_on((b"Position? X\r", b"POSITION? X,900.0,OK\r"), AT_ZERO)
    assert stage.position().reported_mm == 0.0
    assert port.nothing_left_over()


def test_a_lost_completion_line_is_a_timeout_that_names_the_way_done() -> None:
    """The profile's 0.45 s plus 20 % plus 1 s; the motion stays refused-to-all until a stop."""
    stage, port, clock = stage_on(
        AT_ZERO,
        *SPEEDS,
        (b"GoPosition X,O,A,P,1000\r", b"READY\r"),
        (b"Position? X\r", b"POSITION? X,1000.0,OK\r"),
    )
    motion = stage.move_to(2.5, PROFILE)
    started_s = clock.time_s
    with pytest.raises(DeviceTimeout, match=r"2.500 of 2.500 mm done \(reported\)"):
        motion.wait()
    assert clock.time_s - started_s == pytest.approx(1.2 * PROFILE.duration_s(2.5) + 1.0, abs=0.05)
    with pytest.raises(DeviceBusy):
        stage.move_to(0, PROFILE)
    assert port.nothing_left_over()


def test_a_move_whose_ready_is_lost_is_stopped_and_settled_before_the_next() -> None:
    """It may have begun. The next move waits until the stage stands, then goes from there."""
    at_100: Line = (b"Position? X\r", b"POSITION? X,100.0,OK\r")
    stage, port, _ = stage_on(
        AT_ZERO,
        *SPEEDS,
        (b"GoPosition X,O,A,P,1000\r",),
        (b"Stop X\r",),
        (b"SetUnit? X\r", b"SETUNIT? X,s,OK\r"),
        at_100,
        at_100,
        at_100,
        (b"GoPosition X,O,A,P,1000\r", b"READY\r", After(0.45, b"X 1000.0,OK\r")),
        (b"Position? X\r", b"POSITION? X,1000.0,OK\r"),
    )
    with pytest.raises(DeviceTimeout, match="expected Ready in answer to"):
        stage.move_to(2.5, PROFILE)
    assert stage.move_to(2.5, PROFILE).wait().reported_mm == 2.5
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


def test_a_vanished_port_is_an_error_everywhere_and_is_closed_all_the_same() -> None:
    """Even where the stop cannot be sent."""
    stage, port, _ = stage_on()
    port.broken = True
    for call in (stage.position, stage.stop, lambda: stage.move_to(1, PROFILE)):
        with pytest.raises(DeviceDisconnected, match=r"Input/output error|returned no data"):
            call()
    with pytest.raises(DeviceDisconnected):
        stage.__exit__(None, None, None)
    assert port.closed


def test_an_answer_that_comes_twice_is_over_before_the_next_question() -> None:
    """The second copy ends 12 ms after the first: the line has to be silent for 20 ms, and then a fence goes first."""
    stage, port, clock = stage_on(
        AT_ZERO,
        *SPEEDS,
        (b"GoPosition X,O,A,P,40000\r", b"READY\r"),
        (b"Position? X\r", After(0.02, b"POSITION? X,4800.0,OK\r"), After(0.032, b"POSITION? X,4800.0,OK\r")),
        (b"SetUnit? X\r", b"SETUNIT? X,s,OK\r"),
        (b"Position? X\r", After(0.02, b"POSITION? X,5200.0,OK\r")),
    )
    stage.move_to(100, PROFILE)
    clock.sleep_s(0.98)
    assert stage.position().reported_mm == 12.0
    assert stage.position().reported_mm == 13.0
    assert port.nothing_left_over()
