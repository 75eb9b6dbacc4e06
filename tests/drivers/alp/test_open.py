"""Opening a board: the order of the questions, and what is refused."""

import pytest

from protocols import (
    DeviceBusy,
    DeviceError,
    DeviceRefused,
    DriverUnavailable,
    InputError,
    ModulatorLimits,
    PatternModulator,
)
from tests.drivers.alp.fake_alp import DEVICE, FakeAlp

PROBE = 0x80000001


def test_opening_reads_the_board_sets_the_sync_and_takes_the_clock() -> None:
    alp = FakeAlp()
    alp.keep_opening = True
    alp.open(device_number=4711)
    assert alp.calls == [
        ("AlpDevAlloc", 4711, 0),
        ("AlpDevInquire", DEVICE, 2001),
        ("AlpDevInquire", DEVICE, 2021),
        ("AlpDevInquire", DEVICE, 2058),
        ("AlpDevInquire", DEVICE, 2057),
        ("AlpDevInquire", DEVICE, 2003),
        ("AlpProjInquire", DEVICE, 2324),
        ("AlpSeqAlloc", DEVICE, 1, 1),
        ("AlpSeqControl", DEVICE, PROBE, 2110, 2),
        ("AlpSeqControl", DEVICE, PROBE, 2103, 1),
        ("AlpSeqControl", DEVICE, PROBE, 2104, 2106),
        ("AlpSeqTiming", DEVICE, PROBE, 0, 0, 0, 5, 0),
        ("AlpSeqInquire", DEVICE, PROBE, 2211),
        ("AlpSeqInquire", DEVICE, PROBE, 2213),
        ("AlpSeqInquire", DEVICE, PROBE, 2209),
        ("AlpSeqFree", DEVICE, PROBE),
        ("AlpDevInquire", DEVICE, 2000),
        ("AlpDevControl", DEVICE, 2004, 2006),
        ("AlpProjControl", DEVICE, 2300, 2301),
        ("AlpDevControl", DEVICE, 2064, 0),
    ]


def test_limits_are_what_the_board_said() -> None:
    alp = FakeAlp()
    alp.answers |= {2211: 45, 2213: 9_000_000, 2003: 40_000, 2324: 1000}
    driver = alp.open()
    assert isinstance(driver, PatternModulator)
    assert driver.limits == ModulatorLimits(
        columns=1024,
        rows=768,
        shortest_picture_time_us=45,
        longest_picture_time_us=9_000_000,
        unique_patterns=40_000,
        play_order_entries=40_000,
    )


@pytest.mark.parametrize(("flut", "entries"), [("off", 43_690), ("auto", 65_536), ("required", 65_536)])
def test_the_longest_play_order_is_that_of_the_look_up_table_or_of_the_memory(flut: str, entries: int) -> None:
    assert FakeAlp().open(flut=flut).limits.play_order_entries == entries


def test_identity_names_serial_and_version() -> None:
    identity = FakeAlp().open().identity
    assert (identity.name, identity.model, identity.serial) == ("dmd", "DLP7000", "4711")
    assert "fake" in identity.driver
    assert "0x0403" in identity.driver


def test_sync_polarity_low_is_sent_as_2007() -> None:
    alp = FakeAlp()
    alp.keep_opening = True
    alp.open(sync_polarity="low")
    assert ("AlpDevControl", DEVICE, 2004, 2007) in alp.calls


def test_slave_mode_is_refused_with_the_reason_before_the_board_is_touched() -> None:
    alp = FakeAlp()
    with pytest.raises(InputError, match="drops triggers that come too early") as caught:
        alp.open(trigger="slave")
    assert caught.value.exit_code == 2
    assert alp.calls == []


@pytest.mark.parametrize(
    ("answers", "error", "text"),
    [
        ({2021: 255}, DriverUnavailable, "without mirror array"),
        ({2021: 3}, DeviceError, r"DMD type 3 \(DLP9500\)"),
        ({2021: 77}, DeviceError, r"DMD type 77 \(unknown\)"),
        ({2058: 1920, 2057: 1080}, DeviceError, "1920 x 1080 mirrors; expected DMD type 4"),
        ({2001: 0x0301}, DriverUnavailable, "ALP version 0x0301"),
        ({2003: 0}, DeviceError, "0 free pictures of memory"),
        ({2211: 0}, DeviceError, "0 us as shortest picture time"),
    ],
)
def test_a_wrong_board_is_refused_and_let_go(answers: dict[int, int], error: type[DeviceError], text: str) -> None:
    alp = FakeAlp()
    alp.answers |= answers
    with pytest.raises(error, match=text):
        alp.open()
    assert (alp.held, alp.sequences) == (False, {})
    assert alp.calls[-2:] == [("AlpDevHalt", DEVICE), ("AlpDevFree", DEVICE)]


def test_a_board_that_breaks_while_its_times_are_read_is_left_without_a_sequence() -> None:
    alp = FakeAlp()
    alp.codes["AlpSeqInquire", 2211] = 1005
    with pytest.raises(DeviceError, match="AlpSeqInquire"):
        alp.open()
    assert alp.calls[-3:] == [("AlpSeqFree", DEVICE, PROBE), ("AlpDevHalt", DEVICE), ("AlpDevFree", DEVICE)]


def test_a_board_without_room_for_one_picture_is_let_go_and_no_fault_of_the_plan() -> None:
    alp = FakeAlp()
    alp.codes["AlpSeqAlloc"] = 1007
    with pytest.raises(DeviceError, match=r"no room for a single pattern.*1007.*power-cycle") as caught:
        alp.open()
    assert caught.value.exit_code == 3
    assert alp.calls[-2:] == [("AlpDevHalt", DEVICE), ("AlpDevFree", DEVICE)]


def test_an_unknown_version_can_be_accepted_by_setting() -> None:
    alp = FakeAlp()
    alp.answers[2001] = 20
    assert alp.open(accept_any_version=True).identity.driver.endswith("0x0014")


@pytest.mark.parametrize(
    ("code", "error", "asked"),
    [(1004, DeviceBusy, 1), (1010, DeviceRefused, 1), *((code, DriverUnavailable, 9) for code in (1001, 1011, 1012))],
)
def test_a_board_that_cannot_be_taken_is_not_freed(code: int, error: type[DeviceError], asked: int) -> None:
    """1001, 1011 and 1012 were seen on boards that were let go of a moment ago: they are asked again for two seconds."""
    alp = FakeAlp()
    alp.codes["AlpDevAlloc"] = code
    begun_s = alp.clock.now_s()
    with pytest.raises(error, match=str(code)):
        alp.open()
    assert alp.calls == [("AlpDevAlloc", 0, 0)] * asked
    assert alp.clock.now_s() - begun_s == (2.0 if asked == 9 else 0.0)


def test_a_board_that_is_there_a_moment_later_is_taken() -> None:
    alp = FakeAlp()
    alp.keep_opening, alp.fail_at = True, (0, 1001)
    assert alp.open().identity.serial == "4711"
    assert alp.calls[:3] == [("AlpDevAlloc", 0, 0), ("AlpDevAlloc", 0, 0), ("AlpDevInquire", DEVICE, 2001)]


def test_a_board_that_may_be_held_says_by_whom_and_what_to_do() -> None:
    """1001 was seen for a board in use; one whose owner was killed stays allocated until it is switched off."""
    alp = FakeAlp()
    alp.codes["AlpDevAlloc"] = 1001
    with pytest.raises(
        DriverUnavailable, match=r"asked for two seconds; or one that another program holds.*close other"
    ):
        alp.open()
    alp.codes["AlpDevAlloc"] = 1004
    with pytest.raises(
        DeviceBusy, match=r"another program, or by one that was killed.*switch the board off for ten seconds"
    ):
        alp.open()


def test_a_board_that_does_not_know_the_look_up_table_works_without() -> None:
    alp = FakeAlp()
    alp.codes["AlpProjInquire", 2324] = 1005
    assert alp.open().limits.play_order_entries == 43_690


def test_a_required_look_up_table_that_is_missing_is_an_error() -> None:
    alp = FakeAlp()
    alp.answers[2324] = 0
    with pytest.raises(DeviceError, match='set flut = "auto"'):
        alp.open(flut="required")
    assert not alp.held


def test_a_broken_cable_is_not_taken_for_a_missing_look_up_table() -> None:
    alp = FakeAlp()
    alp.codes["AlpProjInquire", 2324] = 1011
    with pytest.raises(DeviceError, match="1011"):
        alp.open()


def test_a_board_that_cannot_park_its_mirrors_says_which_setting_helps() -> None:
    alp = FakeAlp()
    alp.codes["AlpDevControl", 2064] = 1005
    with pytest.raises(DeviceError, match='after_halt = "hold"'):
        alp.open()
    alp.open(after_halt="hold")
    assert alp.held
