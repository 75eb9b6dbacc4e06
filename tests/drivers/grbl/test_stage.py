"""The driver on a scripted line: bytes sent, bytes answered, nothing left over."""

import pytest

from drivers.grbl.driver import open_grbl
from drivers.grbl.settings import GrblSettings
from drivers.polled_stage import PolledStage
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
)
from tests.drivers.serial_line.scripted import Clock, Line, Port

PROFILE = MotionProfile(velocity_mm_s=25, acceleration_mm_s2=50)
WHO: Line = (b"$I\n", b"[VER:1.1f.20170801:]\r\n[OPT:VL,16,128]\r\nok\r\n")
SETTINGS: Line = (b"$$\n", b"$13=0\r\n$20=0\r\n$100=400.000\r\n$110=3000.000\r\n$120=50.000\r\n$130=400.000\r\nok\r\n")


def at(mm: float, state: str = "Idle") -> Line:
    return b"?", f"<{state}|MPos:{mm:.3f},0.000,0.000|FS:0,0>\r\n".encode()


OPENS = (WHO, SETTINGS, at(0.0))
JOG: Line = (b"$J=G53G90G21X2.5000F1500.000\n", b"ok\r\n")


def settings(**changes: object) -> GrblSettings:
    return GrblSettings.model_validate(
        {"travel_mm": (0.0, 400.0), "max_velocity_mm_s": 50.0, "max_acceleration_mm_s2": 200.0, **changes}
    )


def stage_on(*lines: Line, opens: tuple[Line, ...] = OPENS, **changes: object) -> tuple[PolledStage, Port, Clock]:
    port, clock = Port([*opens, *lines]), Clock()
    return open_grbl(settings(**changes), BenchContext(clock=clock, transport=port)), port, clock


def test_opening_asks_who_is_there_for_its_settings_and_where_it_is() -> None:
    stage, port, _ = stage_on()
    assert port.script == []
    assert (stage.identity.vendor, stage.identity.firmware) == ("GRBL", "1.1f.20170801")
    assert not stage_on(at(0.0))[0].homed


def test_a_move_is_one_jog_and_is_over_when_it_is_idle() -> None:
    """``$120`` is 50 already, so it is not written: its memory wears out."""
    stage, port, _ = stage_on(at(0.0), JOG, at(1.0, "Jog"), at(2.5))
    assert stage.move_to(2.5, PROFILE).wait().reported_mm == 2.5
    assert port.script == []


def test_another_acceleration_is_written_once() -> None:
    soft = PROFILE.model_copy(update={"acceleration_mm_s2": 20.0})
    stage, port, _ = stage_on(
        at(0.0),
        (b"$120=20.000\n", b"ok\r\n"),
        JOG,
        at(2.5),
        at(2.5),
        (b"$J=G53G90G21X0.0000F1500.000\n", b"ok\r\n"),
        at(0.0),
    )
    stage.move_to(2.5, soft).wait()
    stage.move_to(0.0, soft).wait()
    assert port.script == []


def test_a_refused_jog_is_told_in_words() -> None:
    stage, _, _ = stage_on(at(0.0), (JOG[0], b"error:8\r\n"))
    with pytest.raises(DeviceRefused, match="not idle") as refused:
        stage.move_to(2.5, PROFILE)
    assert refused.value.code == "error:8"
    assert "unlock = true" in refused.value.remedy


def test_a_jog_without_ok_may_have_begun_so_it_is_cancelled_and_the_next_line_waits_behind_a_fence() -> None:
    """The ``ok`` that comes late is dropped: it stands before the answer to ``$I``."""
    soft = PROFILE.model_copy(update={"acceleration_mm_s2": 20.0})
    stage, port, _ = stage_on(
        at(0.0),
        (JOG[0],),
        (b"\x85", b"ok\r\n"),
        at(0.1),
        at(0.1),
        at(0.1),
        WHO,
        (b"$120=20.000\n", b"ok\r\n"),
        JOG,
        at(2.5),
    )
    with pytest.raises(DeviceTimeout, match="ok in answer to"):
        stage.move_to(2.5, PROFILE)
    assert stage.move_to(2.5, soft).wait().reported_mm == 2.5
    assert port.script == []


def test_a_stop_cancels_the_jog_and_the_motion_says_where_it_stands() -> None:
    stage, port, _ = stage_on(at(0.0), JOG, (b"\x85",), at(1.2, "Jog"), at(1.3), at(1.3))
    motion = stage.move_to(2.5, PROFILE)
    stage.stop()
    with pytest.raises(DeviceError, match=r"over at 1\.3 mm, after a stop"):
        motion.wait()
    assert port.script == []


def test_a_stop_that_comes_before_the_ok_is_sent_again_behind_it() -> None:
    """A jog cancel outside of a jog is without effect, and the jog would begin behind it."""
    stage, port, clock = stage_on(at(0.0), (JOG[0],), (b"\x85", b"ok\r\n"), (b"\x85",), at(0.1), at(0.1))
    asked_s = clock.now_s()

    def stop_after_the_jog_is_on_its_way() -> None:
        if len(port.script) > 4:
            clock.meanwhile = stop_after_the_jog_is_on_its_way
        else:
            stage.stop()

    clock.meanwhile = stop_after_the_jog_is_on_its_way
    motion = stage.move_to(2.5, PROFILE)
    with pytest.raises(DeviceError, match="after a stop"):
        motion.wait()
    assert clock.now_s() - asked_s < 1.0
    assert port.script == []


def test_homing_asks_nothing_until_its_ok() -> None:
    stage, port, clock = stage_on(at(5.0), (b"$H\n",), at(0.0), at(0.0))
    motion = stage.home()
    assert not motion.done
    assert stage.position().predicted
    port.say(b"ok\r\n")
    assert motion.wait().reported_mm == 0.0
    assert stage.homed
    assert port.script == []
    assert clock.now_s() < 1.0


def test_a_stop_of_homing_resets_and_the_origin_is_lost() -> None:
    stage, port, _ = stage_on(
        at(5.0),
        (b"$H\n",),
        (b"\x18", b"ALARM:6\r\n\r\nGrbl 1.1f ['$' for help]\r\n[MSG:'$H'|'$X' to unlock]\r\n"),
        at(4.0, "Alarm"),
        at(4.0, "Alarm"),
        at(4.0, "Alarm"),
    )
    motion = stage.home()
    stage.stop()
    with pytest.raises(DeviceError, match="ALARM:6"):
        motion.wait()
    assert not stage.homed
    assert port.script == []


def test_homing_without_a_switch_ends_by_its_alarm() -> None:
    stage, port, _ = stage_on(at(5.0), (b"$H\n",), at(3.0, "Alarm"), at(3.0, "Alarm"))
    motion = stage.home()
    port.say(b"ALARM:9\r\n")
    with pytest.raises(DeviceError, match="no switch was found"):
        motion.wait()
    assert port.script == []


def test_after_a_limit_switch_it_is_reset_to_be_asked_and_only_homing_leads_on() -> None:
    """It would answer nothing until then; afterwards it is locked."""
    reset: Line = (b"\x18", b"\r\nGrbl 1.1f ['$' for help]\r\n[MSG:'$H'|'$X' to unlock]\r\n")
    there = at(1.4, "Alarm")
    stage, port, _ = stage_on(at(0.0), JOG, at(1.0, "Jog"), reset, there, there, there, (JOG[0], b"error:8\r\n"))
    motion = stage.move_to(2.5, PROFILE)
    assert not motion.done
    port.say(b"ALARM:1\r\n[MSG:Reset to continue]\r\n")
    with pytest.raises(DeviceError, match=r"over at 1\.4 mm; the controller says: ALARM:1, a limit switch"):
        motion.wait()
    with pytest.raises(DeviceRefused, match="locked by an alarm; ALARM:1"):
        stage.move_to(2.5, PROFILE)
    port.expect(there, (b"$H\n", b"ok\r\n"), at(0.0), at(0.0))
    assert stage.home().wait().reported_mm == 0.0
    assert stage.homed
    assert port.script == []


def test_a_position_in_work_coordinates_waits_for_the_offset() -> None:
    """The offset comes seldom, and is kept."""
    without = (b"?", b"<Idle|WPos:1.000,0.000,0.000|FS:0,0>\r\n")
    with_it = (b"?", b"<Idle|WPos:1.000,0.000,0.000|FS:0,0|WCO:10.000,0.000,0.000>\r\n")
    stage, port, _ = stage_on(without, opens=(WHO, SETTINGS, without, without, with_it))
    assert stage.position().reported_mm == 11.0
    assert port.script == []


def test_a_lock_is_released_only_where_bench_toml_says_so() -> None:
    locked = (WHO, SETTINGS, at(0.0, "Alarm"))
    _, port, _ = stage_on(at(0.0, "Alarm"), (b"$X\n", b"[MSG:Caution: Unlocked]\r\nok\r\n"), opens=locked, unlock=True)
    assert port.script == []
    stage_on(opens=locked)


@pytest.mark.parametrize(
    ("stored", "says"),
    [
        (b"$110=2999.000\r\nok\r\n", r"at most 49.9833: the controller clips"),
        (b"$13=1\r\nok\r\n", "inches"),
        (b"$20=1\r\n$130=399.000\r\nok\r\n", "at most 399 mm"),
    ],
)
def test_what_the_controller_would_clip_or_refuse_is_refused_at_opening(stored: bytes, says: str) -> None:
    with pytest.raises(InputError, match=says):
        stage_on(opens=(WHO, (b"$$\n", stored)))


def test_a_board_that_starts_when_its_port_is_opened_is_waited_for() -> None:
    stage, port, _ = stage_on(opens=((b"$I\n",), (b"$I\n",), *OPENS))
    assert stage.identity.firmware == "1.1f.20170801"
    assert port.script == []


def test_silence_at_opening_names_what_to_check() -> None:
    port, clock = Port([(b"$I\n",)] * 6), Clock()
    with pytest.raises(DriverUnavailable, match="not a byte"):
        open_grbl(settings(), BenchContext(clock=clock, transport=port))
    assert port.closed
    assert 3.0 <= clock.now_s() < 4.0


def test_a_start_velocity_is_refused_as_the_controller_has_none() -> None:
    stage, _, _ = stage_on()
    with pytest.raises(PlanError, match="start velocity of 1 mm/s"):
        stage.check(1.0, PROFILE.model_copy(update={"initial_velocity_mm_s": 1.0}))


def test_a_port_that_fails_is_a_device_that_is_gone() -> None:
    stage, port, _ = stage_on()
    port.broken = True
    with pytest.raises(DeviceDisconnected):
        stage.position()
