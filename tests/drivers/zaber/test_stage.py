"""The driver on a scripted line: bytes sent, bytes answered, nothing left over."""

import pytest

from drivers.polled_stage import PolledStage
from drivers.zaber.codec import checksum, command
from drivers.zaber.driver import open_zaber
from drivers.zaber.settings import ZaberSettings
from protocols import (
    BenchContext,
    DeviceDisconnected,
    DeviceError,
    DeviceRefused,
    DeviceTimeout,
    DriverUnavailable,
    InputError,
    MotionProfile,
    PlanError,
    ProtocolViolation,
    WrongState,
)
from tests.drivers.serial_line.scripted import Clock, Line, Port

PROFILE = MotionProfile(velocity_mm_s=25, acceleration_mm_s2=50)


def reply(message_id: int, data: str = "0", state: str = "IDLE --", flag: str = "OK") -> bytes:
    text = f"01 1 {message_id:02d} {flag} {state} {data}"
    return f"@{text}:{checksum(text)}\r\n".encode()


def asked(message_id: int, words: str, data: str = "0", state: str = "IDLE --") -> Line:
    return command(1, 1, message_id, words), reply(message_id, data, state)


OPENS = (
    asked(1, "get version", "7.34"),
    asked(2, "get deviceid", "50081"),
    asked(3, "get limit.min", "0"),
    asked(4, "get limit.max", "6250000"),
)
SPEEDS = (asked(6, "set maxspeed 640000"), asked(7, "set accel 128"))


def stage_on(*lines: Line, **changes: object) -> tuple[PolledStage, Port, Clock]:
    values: dict[str, object] = {
        "microsteps_per_mm": 15_625,
        "travel_mm": (0.0, 400.0),
        "max_velocity_mm_s": 50.0,
        "max_acceleration_mm_s2": 200.0,
        **changes,
    }
    port, clock = Port([*OPENS, *lines]), Clock()
    return open_zaber(ZaberSettings.model_validate(values), BenchContext(clock=clock, transport=port)), port, clock


def test_opening_asks_who_is_there_and_how_far_it_may_go() -> None:
    stage, port, _ = stage_on()
    assert port.script == []
    assert (stage.identity.vendor, stage.identity.firmware) == ("Zaber", "7.34")
    assert "50081" in stage.identity.model


def test_a_move_is_speed_acceleration_and_target_in_microsteps_and_ends_when_idle() -> None:
    """25 mm/s x 15625 x 1.6384 = 640000; 50 mm/s^2 x 15625 x 1.6384 / 10000 = 128; 2.5 mm are 39062.5, so 39062 or 39063."""
    stage, port, _ = stage_on(
        asked(5, "get pos"),
        *SPEEDS,
        asked(8, "move abs 39062", state="BUSY --"),
        asked(9, "get pos", "20000", "BUSY --"),
        asked(10, "get pos", "39062"),
    )
    end = stage.move_to(2.5, PROFILE).wait()
    assert end.reported_mm == 39062 / 15_625
    assert port.script == []


def test_by_when_it_stands_follows_from_what_the_controller_runs() -> None:
    """2.5 mm at 50 mm/s^2 are a triangle of 2 sqrt(2.5 / 50) = 0.447 s; a fifth and a second more."""
    stage, _, clock = stage_on(asked(5, "get pos"), *SPEEDS, asked(8, "move abs 39062", state="BUSY --"))
    stage.move_to(2.5, PROFILE)
    assert stage.stands_by_s - clock.now_s() == pytest.approx(1.2 * 0.4472 + 1.0, abs=1e-3)


def test_the_speeds_are_sent_again_only_when_they_change() -> None:
    stage, port, _ = stage_on(
        asked(5, "get pos"),
        *SPEEDS,
        asked(8, "move abs 15625", state="BUSY --"),
        asked(9, "get pos", "15625"),
        asked(10, "get pos", "15625"),
        asked(11, "move abs 0", state="BUSY --"),
        asked(12, "get pos", "0"),
    )
    stage.move_to(1.0, PROFILE).wait()
    assert stage.move_by(-1.0, PROFILE).wait().reported_mm == 0.0
    assert port.script == []


def test_only_the_reply_with_its_own_id_is_an_answer() -> None:
    """An old reply, an alert, an info, a damaged reply and another device's come first."""
    other = b"@02 1 05 OK IDLE -- 1\r\n"
    noise = reply(4, "777") + b"!01 1 IDLE --\r\n#01 0 hello\r\n@01 1 05 OK IDLE -- 9:00\r\n" + other
    stage, port, _ = stage_on((command(1, 1, 5, "get pos"), noise, reply(5, "15625")))
    assert stage.position().reported_mm == 1.0
    assert port.script == []


def test_a_reply_in_two_packets_is_put_together() -> None:
    text = "01 1 01 OK IDLE -- 7\\"  # no checksum: it is the first reply
    port = Port([(command(1, 1, 1, "get version"), f"@{text}\r\n".encode(), b"#01 1 01 cont 34\r\n"), *OPENS[1:]])
    settings = ZaberSettings(
        microsteps_per_mm=15_625, travel_mm=(0, 400), max_velocity_mm_s=50, max_acceleration_mm_s2=200
    )
    assert open_zaber(settings, BenchContext(clock=Clock(), transport=port)).identity.firmware == "7 34"


def test_a_question_without_answer_is_asked_once_more() -> None:
    stage, port, _ = stage_on((command(1, 1, 5, "get pos"),), asked(6, "get pos", "15625"))
    assert stage.position().reported_mm == 1.0
    assert port.script == []


def test_a_move_without_answer_may_have_begun_so_it_is_stopped() -> None:
    stage, port, _ = stage_on(
        asked(5, "get pos"), *SPEEDS, (command(1, 1, 8, "move abs 15625"),), (command(1, 1, 9, "stop"),)
    )
    with pytest.raises(DeviceTimeout, match="id 08"):
        stage.move_to(1.0, PROFILE)
    assert port.script == []


def test_a_rejected_move_carries_the_reason_and_what_to_do() -> None:
    stage, _, _ = stage_on(
        asked(5, "get pos"), *SPEEDS, (command(1, 1, 8, "move abs 15625"), reply(8, "DRIVERDISABLED", "IDLE FO", "RJ"))
    )
    with pytest.raises(DeviceRefused, match="driver enable") as refused:
        stage.move_to(1.0, PROFILE)
    assert refused.value.code == "DRIVERDISABLED"
    assert "FO, driver disabled" in str(refused.value)


def test_a_stall_ends_the_motion_with_the_controllers_own_words() -> None:
    stage, _, _ = stage_on(
        asked(5, "get pos"),
        *SPEEDS,
        asked(8, "move abs 15625", state="BUSY --"),
        asked(9, "get pos", "9000", "IDLE FS"),
        asked(10, "get pos", "9000", "IDLE FS"),
        asked(11, "get pos", "9000", "IDLE FS"),
    )
    with pytest.raises(DeviceError, match="FS, stalled and stopped"):
        stage.move_to(1.0, PROFILE).wait()
    assert not stage.homed, "a stalled stage does not know where it is"


@pytest.mark.parametrize(("flag", "homed"), [("--", True), ("WR", False), ("WH", False), ("NI", True), ("WT", True)])
def test_homed_is_what_the_flags_say(flag: str, homed: bool) -> None:  # noqa: FBT001
    stage, _, _ = stage_on(asked(5, "get pos", state=f"IDLE {flag}"))
    assert stage.homed is homed


def test_a_stage_that_must_be_homed_refuses_to_move_before() -> None:
    stage, port, _ = stage_on(asked(5, "get pos", state="IDLE WR"), require_home=True)
    with pytest.raises(WrongState, match="home"):
        stage.move_to(1.0, PROFILE)
    assert port.script == []


def test_a_stop_that_comes_first_keeps_the_move_from_beginning() -> None:
    stage, port, clock = stage_on(asked(5, "get pos"), (command(1, 1, 6, "stop"), reply(6)))
    clock.meanwhile = stage.stop
    with pytest.raises(AssertionError):  # the script has no more: the driver would set the speeds
        stage.move_to(1.0, PROFILE)
    assert port.script == []


def test_a_position_that_is_no_number_is_a_violation() -> None:
    stage, _, _ = stage_on(asked(5, "get pos", "0 0"))
    with pytest.raises(ProtocolViolation, match="'0 0'"):
        stage.position()


def test_a_start_velocity_is_refused_as_the_controller_has_none() -> None:
    stage, _, _ = stage_on()
    with pytest.raises(PlanError, match="start velocity of 1 mm/s"):
        stage.check(1.0, PROFILE.model_copy(update={"initial_velocity_mm_s": 1.0}))


def test_a_profile_of_less_than_one_unit_is_refused() -> None:
    stage, _, _ = stage_on()
    with pytest.raises(PlanError, match=r"at least 3.91e-05 mm/s and 0.391 mm/s\^2"):
        stage.check(1.0, MotionProfile(velocity_mm_s=25, acceleration_mm_s2=0.19))
    stage.check(1.0, MotionProfile(velocity_mm_s=25, acceleration_mm_s2=0.391))


def test_a_travel_beyond_the_controllers_limits_is_refused_at_opening() -> None:
    with pytest.raises(InputError, match="0 to 400 mm"):
        stage_on(travel_mm=(0.0, 400.1))


def test_silence_at_opening_names_what_to_check() -> None:
    first = command(1, 1, 1, "get version")
    port = Port([(first,), (command(1, 1, 2, "get version"),)])
    settings = ZaberSettings(
        microsteps_per_mm=15_625, travel_mm=(0, 400), max_velocity_mm_s=50, max_acceleration_mm_s2=200
    )
    with pytest.raises(DriverUnavailable, match="not a byte"):
        open_zaber(settings, BenchContext(clock=Clock(), transport=port))
    assert port.closed


def test_a_port_that_fails_is_a_device_that_is_gone() -> None:
    stage, port, _ = stage_on()
    port.broken = True
    with pytest.raises(DeviceDisconnected):
        stage.position()


def test_leaving_stops_and_gives_the_port_back_once() -> None:
    stage, port, _ = stage_on((command(1, 1, 5, "stop"),))
    with stage:
        pass
    stage.__exit__(None, None, None)
    assert port.closed
    assert port.script == []
