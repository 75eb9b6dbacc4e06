"""Playing: start, wait, halt, replay, and what is said when it goes wrong."""

import pytest

from drivers.alp import Dlp7000
from protocols import DeviceDisconnected, DeviceError, DeviceRefused, DeviceTimeout, ProtocolViolation, WrongState
from tests.drivers.alp.fake_alp import DEVICE, FakeAlp
from tests.drivers.alp.patterns import TIMING, sequence

FIRST = 0x80000002


def loaded(alp: FakeAlp, pictures: int = 2001, **settings: object) -> Dlp7000:
    """A driver with so many pictures of 50 us in its board, and nothing on record."""
    driver = alp.open(**settings)
    driver.load(sequence(3, [1, 2] * (pictures // 2) + [0]), TIMING)
    alp.calls.clear()
    return driver


def test_a_run_of_2001_pictures_of_50_us_ends_after_100_ms() -> None:
    alp = FakeAlp()
    driver = loaded(alp)
    driver.start()
    running = [driver.running]
    driver.wait(1.0)
    running.append(driver.running)
    assert running == [True, False]
    assert alp.clock.now_s() - 100.0 == pytest.approx(2001 * 50e-6, abs=2e-3)
    assert alp.calls[0] == ("AlpProjStart", DEVICE, FIRST)
    assert set(alp.calls[1:]) == {("AlpProjInquire", DEVICE, 2400)}, "the projection is asked without a sequence id"
    driver.wait(0.0)  # waiting again for a run that is over returns


def test_start_again_replays_without_a_second_upload() -> None:
    alp = FakeAlp()
    driver = loaded(alp)
    for _ in range(2):
        driver.start()
        driver.wait(1.0)
    assert alp.named("AlpProjStart", "AlpSeqPut") == [("AlpProjStart", DEVICE, FIRST)] * 2


def test_start_while_playing_is_refused() -> None:
    driver = loaded(FakeAlp())
    driver.start()
    with pytest.raises(WrongState, match="start while the last run still plays"):
        driver.start()


def test_start_and_wait_out_of_turn_say_what_is_missing() -> None:
    driver = FakeAlp().open()
    with pytest.raises(WrongState, match="call load first"):
        driver.start()
    with pytest.raises(WrongState, match="call start first"):
        driver.wait(1.0)


def test_a_start_that_fails_halts_the_board() -> None:
    alp = FakeAlp()
    driver = loaded(alp)
    alp.codes["AlpProjStart"] = 1011
    with pytest.raises(DeviceDisconnected):
        driver.start()
    assert alp.calls[-1] == ("AlpDevHalt", DEVICE)
    assert not driver.running


def test_a_timeout_tells_how_many_pictures_were_shown_and_leaves_the_run_alone() -> None:
    alp = FakeAlp()
    driver = loaded(alp)
    driver.start()
    alp.frames_left = 1601
    with pytest.raises(DeviceTimeout, match=r"saw 400 of 2001 pictures shown after 0.02 s.*take 0.1 s.*wait longer"):
        driver.wait(0.02)
    assert driver.running
    driver.wait(1.0)


def test_a_board_that_never_ends_is_a_timeout_too() -> None:
    alp = FakeAlp()
    driver = loaded(alp)
    driver.start()
    alp.plays_until_s = float("inf")
    alp.codes["AlpProjInquireEx"] = 1005
    with pytest.raises(DeviceTimeout, match=r"still playing 2001 pictures .*halt the board"):
        driver.wait(0.5)
    assert alp.clock.now_s() - 100.0 == pytest.approx(0.5, abs=1e-3)
    assert len(alp.named("AlpProjInquire")) < 500, "asked no more than once a millisecond"


def test_a_board_that_stops_by_itself_is_not_taken_for_a_run_played_to_its_end() -> None:
    alp = FakeAlp()
    driver = loaded(alp)
    driver.start()
    alp.plays_until_s = alp.clock.now_s() + 0.03
    with pytest.raises(DeviceError, match=r"an idle board 0.04 s after the start; expected 2001 pictures for 0.1 s"):
        driver.wait(1.0)


def test_a_board_clock_that_runs_fast_by_half_a_per_cent_is_fine() -> None:
    alp = FakeAlp()
    driver = loaded(alp)
    driver.start()
    alp.plays_until_s = alp.clock.now_s() + 0.995 * 2001 * 50e-6
    driver.wait(1.0)


def test_a_halt_in_mid_run_parks_the_mirrors_and_the_next_start_wakes_them() -> None:
    alp = FakeAlp()
    driver = loaded(alp)
    driver.start()
    driver.halt()
    assert not driver.running
    driver.halt()
    driver.start()
    assert [call for call in alp.calls if call[0] != "AlpProjInquire"] == [
        ("AlpProjStart", DEVICE, FIRST),
        ("AlpDevHalt", DEVICE),
        ("AlpDevControl", DEVICE, 2064, 1),
        ("AlpDevHalt", DEVICE),
        ("AlpDevControl", DEVICE, 2064, 0),
        ("AlpProjStart", DEVICE, FIRST),
    ]


def test_after_halt_hold_leaves_the_mirrors_as_the_board_does() -> None:
    alp = FakeAlp()
    driver = loaded(alp, after_halt="hold")
    driver.start()
    driver.halt()
    assert alp.named("AlpDevControl") == []


def test_a_halt_after_the_end_parks_nothing_because_the_guard_is_dark() -> None:
    alp = FakeAlp()
    driver = loaded(alp)
    driver.start()
    driver.wait(1.0)
    driver.halt()
    assert alp.named("AlpDevControl") == []
    driver.wait(0.0)


def test_a_halt_is_tried_even_if_the_board_does_not_tell_its_state() -> None:
    alp = FakeAlp()
    driver = loaded(alp)
    driver.start()
    alp.codes["AlpProjInquire"] = 1999
    driver.halt()
    assert alp.named("AlpDevHalt", "AlpDevControl") == [("AlpDevHalt", DEVICE), ("AlpDevControl", DEVICE, 2064, 1)]


def test_whoever_waits_for_a_halted_run_is_told() -> None:
    alp = FakeAlp()
    driver = loaded(alp)
    driver.start()
    driver.halt()
    with pytest.raises(WrongState, match="a run that was halted"):
        driver.wait(1.0)


def test_mirrors_that_do_not_wake_are_an_error_of_the_next_start() -> None:
    alp = FakeAlp()
    driver = loaded(alp)
    driver.start()
    driver.halt()
    alp.codes["AlpDevControl", 2064] = 1018
    with pytest.raises(DeviceRefused, match="do not wake"):
        driver.start()


def test_an_unknown_projection_state_is_a_violation() -> None:
    alp = FakeAlp()
    driver = loaded(alp)
    driver.start()
    alp.answers[2400] = 1234
    with pytest.raises(ProtocolViolation, match="1234"):
        driver.wait(1.0)
