"""Loading: what is stored, in which order it is told, and that a failure leaves nothing behind."""

from threading import Thread

import pytest

from drivers.alp.upload import plan_upload
from protocols import (
    DeviceDisconnected,
    DeviceError,
    DeviceRefused,
    ModulatorTiming,
    PatternMemoryFull,
    PatternSequence,
    PictureTimeTooShort,
    PixelGrid,
    PlanError,
    WrongState,
)
from tests.drivers.alp.fake_alp import DEVICE, FakeAlp
from tests.drivers.alp.patterns import TIMING, number_shown, sequence

FIRST = 0x80000002
"""Id of the first sequence loaded; the one before was the probe at opening."""


def test_a_sequence_is_loaded_in_the_order_of_the_fact_sheet() -> None:
    alp = FakeAlp()
    kept = alp.open().load(sequence(3, [1, 2, 1, 2, 0]), ModulatorTiming(picture_time_us=50, sync_width_us=7))
    assert kept == ModulatorTiming(picture_time_us=50, sync_delay_us=0, sync_width_us=7)
    assert alp.calls == [
        ("AlpSeqAlloc", DEVICE, 1, 3),
        ("AlpSeqControl", DEVICE, FIRST, 2110, 2),
        ("AlpSeqControl", DEVICE, FIRST, 2103, 1),
        ("AlpSeqControl", DEVICE, FIRST, 2104, 2106),
        ("AlpSeqControl", DEVICE, FIRST, 2100, 1),
        ("AlpSeqControl", DEVICE, FIRST, 2118, 1),
        ("AlpSeqControl", DEVICE, FIRST, 2120, 5),
        ("AlpSeqControl", DEVICE, FIRST, 2122, 0),
        ("AlpProjControlEx", DEVICE, 2325),
        ("AlpSeqTiming", DEVICE, FIRST, 0, 50, 0, 7, 0),
        ("AlpSeqInquire", DEVICE, FIRST, 2203),
        ("AlpSeqInquire", DEVICE, FIRST, 2205),
        ("AlpSeqInquire", DEVICE, FIRST, 2206),
        ("AlpSeqPut", DEVICE, FIRST, 0, 3),
    ]
    assert alp.flut == [1, 2, 1, 2, 0]


def test_each_unique_plane_is_uploaded_once_as_the_mirrors_of_the_sequence() -> None:
    alp, patterns = FakeAlp(), sequence(3, [1, 2, 1, 2, 0])
    alp.open().load(patterns, TIMING)
    assert alp.stored == {place: patterns.mirror_plane(place).tobytes() for place in range(3)}


def test_more_than_512_planes_take_18_bit_entries_which_count_twice() -> None:
    alp = FakeAlp()
    order = [*range(1, 513)] * 10 + [0]
    alp.open(upload_batch=200).load(sequence(513, order), TIMING)
    assert ("AlpSeqControl", DEVICE, FIRST, 2118, 2) in alp.calls
    assert ("AlpSeqControl", DEVICE, FIRST, 2120, 2 * 5121) in alp.calls
    assert alp.named("AlpProjControlEx") == [("AlpProjControlEx", DEVICE, 2326)] * 2, "5121 entries, 4096 a call"
    assert alp.flut == order
    assert alp.named("AlpSeqPut") == [
        ("AlpSeqPut", DEVICE, FIRST, 0, 200),
        ("AlpSeqPut", DEVICE, FIRST, 200, 200),
        ("AlpSeqPut", DEVICE, FIRST, 400, 113),
    ]


@pytest.mark.parametrize("reason", ["no table", "switched off", "table too short"])
def test_without_a_usable_table_the_planes_are_stored_in_play_order(reason: str) -> None:
    alp = FakeAlp()
    alp.answers[2324] = {"no table": 0, "switched off": 65_536, "table too short": 4}[reason]
    driver = alp.open(flut="off" if reason == "switched off" else "auto", upload_batch=2)
    seen: list[tuple[int, int]] = []
    driver.load(sequence(3, [1, 2, 1, 2, 0]), TIMING, lambda done, total: seen.append((done, total)))
    assert [number_shown(alp.stored[place]) for place in range(5)] == [1, 2, 1, 2, 0]
    assert ("AlpSeqAlloc", DEVICE, 1, 5) in alp.calls
    assert alp.named("AlpProjControlEx") == []
    assert seen == [(2, 3), (2, 3), (3, 3)], "unique patterns stored, unique patterns in all"


@pytest.mark.parametrize(("entries9", "mode"), [(2 * 513, 2), (2 * 513 - 1, 0)])
def test_an_18_bit_table_must_have_two_places_for_each_picture(entries9: int, mode: int) -> None:
    plan = plan_upload(sequence(513), memory=1000, table_entries9=entries9, flut="auto", device="dmd")
    assert plan.mode == mode


def test_progress_is_told_after_each_batch() -> None:
    seen: list[tuple[int, int]] = []
    FakeAlp().open(upload_batch=2).load(sequence(5), TIMING, lambda done, total: seen.append((done, total)))
    assert seen == [(2, 5), (4, 5), (5, 5)]


def test_the_leftmost_mirror_is_the_highest_bit_unless_set_otherwise() -> None:
    stored: dict[str, int] = {}
    for order in ("msb-first", "lsb-first"):
        alp = FakeAlp()
        alp.open(bit_order=order).load(sequence(7), TIMING)
        stored[order] = alp.stored[6][376 * 128 + 64]
    assert stored == {"msb-first": 0b0000_0110, "lsb-first": 0b0110_0000}


@pytest.mark.parametrize(
    ("memory", "entries9", "flut", "text"),
    [
        (2, 65_536, "auto", "saw 3 unique patterns; expected at most 2"),
        (4, 0, "auto", "saw 5 pictures to be stored in play order .*expected at most 4"),
        (
            4,
            65_536,
            "off",
            r"saw 5 pictures to be stored in play order \(frame look-up table: off\); expected at most 4",
        ),
        (40, 4, "required", "saw 5 pictures for the frame look-up table; expected at most 4"),
    ],
)
def test_what_does_not_fit_is_refused_before_the_board_is_touched(
    memory: int, entries9: int, flut: str, text: str
) -> None:
    alp = FakeAlp()
    alp.answers |= {2003: memory, 2324: entries9}
    with pytest.raises(PatternMemoryFull, match=text):
        alp.open(flut=flut).load(sequence(3, [1, 2, 1, 2, 0]), TIMING)
    assert alp.calls == []


def test_a_fragmented_memory_names_both_numbers() -> None:
    alp = FakeAlp()
    driver = alp.open()
    alp.codes["AlpSeqAlloc"] = 1007
    alp.answers[2003] = 2
    with pytest.raises(PatternMemoryFull, match=r"saw 3 patterns in one piece .*1007.*expected at most 2"):
        driver.load(sequence(3), TIMING)


@pytest.mark.parametrize(
    ("timing", "error", "text"),
    [
        (ModulatorTiming(picture_time_us=43), PictureTimeTooShort, "at least 44 us"),
        (ModulatorTiming(picture_time_us=10_000_001), PlanError, "at most 10000000 us"),
        (ModulatorTiming(picture_time_us=50, sync_width_us=50), PlanError, "at most 49 us"),
        (ModulatorTiming(picture_time_us=50, sync_delay_us=130_001), PlanError, "at most 130000 us"),
    ],
)
def test_impossible_times_are_refused_before_the_board_is_touched(
    timing: ModulatorTiming, error: type[PlanError], text: str
) -> None:
    alp = FakeAlp()
    with pytest.raises(error, match=text):
        alp.open().load(sequence(), timing)
    assert alp.calls == []


def test_the_shortest_picture_time_of_44_us_is_accepted() -> None:
    assert FakeAlp().open().load(sequence(), ModulatorTiming(picture_time_us=44)).picture_time_us == 44


def test_patterns_for_other_mirrors_are_refused() -> None:
    one = sequence()
    other = PatternSequence(
        one.planes, one.play_order, PixelGrid(image_size=16, superpixel=1, columns=1920, rows=1080), samples=16
    )
    with pytest.raises(PlanError, match="1920 x 1080 mirrors; expected 1024 x 768"):
        FakeAlp().open().load(other, TIMING)


def test_the_timing_returned_is_the_boards_not_the_one_asked_for() -> None:
    alp = FakeAlp()
    driver = alp.open()
    alp.answers |= {2203: 52, 2205: 1, 2206: 6}
    assert driver.load(sequence(), TIMING) == ModulatorTiming(picture_time_us=52, sync_delay_us=1, sync_width_us=6)


def test_an_impossible_timing_from_the_board_is_an_error_and_leaves_nothing() -> None:
    alp = FakeAlp()
    driver = alp.open()
    alp.answers[2203] = 0
    with pytest.raises(DeviceError, match="a picture time of 0 us"):
        driver.load(sequence(), TIMING)
    assert alp.sequences == {}


@pytest.mark.parametrize(
    "broken",
    ["AlpSeqControl", "AlpProjControlEx", "AlpSeqTiming", "AlpSeqInquire", "AlpSeqPut"],
)
def test_a_failed_load_frees_the_sequence_and_the_device_can_be_loaded_again(broken: str) -> None:
    alp = FakeAlp()
    driver = alp.open()
    alp.codes[broken] = 1005
    with pytest.raises(DeviceRefused, match=broken) as caught:
        driver.load(sequence(), TIMING)
    assert caught.value.code == "1005"
    assert alp.sequences == {}
    with pytest.raises(WrongState, match="call load first"):
        driver.start()
    alp.codes.clear()
    alp.flut.clear()
    driver.load(sequence(), TIMING)
    driver.start()
    assert driver.running


def test_a_second_load_frees_the_first_sequence_before_it_allocates() -> None:
    alp = FakeAlp()
    driver = alp.open()
    driver.load(sequence(), TIMING)
    alp.calls.clear()
    alp.flut.clear()
    driver.load(sequence(4), TIMING)
    assert alp.calls[:2] == [("AlpSeqFree", DEVICE, FIRST), ("AlpSeqAlloc", DEVICE, 1, 4)]


def test_a_refused_plan_leaves_the_earlier_sequence_in_the_board() -> None:
    driver = FakeAlp().open()
    driver.load(sequence(), TIMING)
    with pytest.raises(PictureTimeTooShort):
        driver.load(sequence(), ModulatorTiming(picture_time_us=20))
    driver.start()
    assert driver.running


def test_load_is_refused_while_pictures_are_played() -> None:
    driver = FakeAlp().open()
    driver.load(sequence(), TIMING)
    driver.start()
    with pytest.raises(WrongState, match="load while the last run still plays"):
        driver.load(sequence(), TIMING)


def test_a_halt_from_another_thread_reaches_the_board_inside_the_upload() -> None:
    alp = FakeAlp()
    driver = alp.open(upload_batch=1)

    def halted() -> int:
        thread = Thread(target=driver.halt)
        thread.start()
        thread.join(5.0)
        assert not thread.is_alive(), "the halt waits behind the upload"
        return 1009

    alp.during_put = halted
    with pytest.raises(WrongState, match="1009"):
        driver.load(sequence(), TIMING)
    assert alp.named("AlpSeqPut", "AlpDevHalt", "AlpSeqFree") == [
        ("AlpSeqPut", DEVICE, FIRST, 0, 1),
        ("AlpDevHalt", DEVICE),
        ("AlpSeqFree", DEVICE, FIRST),
    ]


@pytest.mark.parametrize("batch", [1, 3])
def test_a_halt_between_or_after_batches_ends_the_upload_too(batch: int) -> None:
    alp = FakeAlp()
    driver = alp.open(upload_batch=batch)
    with pytest.raises(WrongState, match="a halt during the upload"):
        driver.load(sequence(3), TIMING, lambda _done, _total: driver.halt())
    assert len(alp.named("AlpSeqPut")) == 1
    assert alp.sequences == {}


def test_nothing_else_may_be_started_during_an_upload() -> None:
    driver = FakeAlp().open()
    refused: list[str] = []

    def meddle(_done: int, _total: int) -> None:
        for call in (driver.start, lambda: driver.load(sequence(), TIMING)):
            with pytest.raises(WrongState) as caught:
                call()
            refused.append(caught.value.saw)
        assert not driver.running

    driver.load(sequence(), TIMING, meddle)
    assert refused == ["start during an upload", "load during an upload"]


def test_an_interrupted_upload_is_freed_and_what_fails_then_is_a_note() -> None:
    alp = FakeAlp()
    driver = alp.open()
    alp.codes["AlpSeqFree"] = 1012

    def interrupt(_done: int, _total: int) -> None:
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt) as caught:
        driver.load(sequence(), TIMING, interrupt)
    assert "1012" in caught.value.__notes__[0]


def test_a_board_unplugged_during_the_upload_is_named_so() -> None:
    alp = FakeAlp()
    driver = alp.open()
    alp.codes["AlpSeqPut"] = 1012
    with pytest.raises(DeviceDisconnected, match="unplugged"):
        driver.load(sequence(), TIMING)
