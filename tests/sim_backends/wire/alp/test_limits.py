"""Limits and defaults of dlp7000.md 3.4, 3.5 and 3.10, on both sides of each, by the sheet's own numbers."""

import pytest

from tests.sim_backends.wire.alp.client import Client, packed

REPEAT, FIRST, LAST, BITNUM, BIN_MODE, FORMAT, FLUT_MODE = 2100, 2101, 2102, 2103, 2104, 2110, 2118
FLUT_ENTRIES9, FLUT_OFFSET9, DMD_LINES = 2120, 2122, 2125
BITPLANES, PICNUM, PICTURE, ILLUMINATE, DELAY, PULSE, TRIGGER_DELAY = 2200, 2201, 2203, 2204, 2205, 2206, 2207
MAX_DELAY, ON, OFF = 2209, 2214, 2215
NORMAL, UNINTERRUPTED = 2105, 2106
INVALID = 1005


def _normal_sequence(alp: Client, device: int, pictures: int = 4) -> int:
    code, sequence = alp.ask("AlpSeqAlloc", device, 1, pictures)
    assert code == 0
    return sequence


def _told(alp: Client, device: int, sequence: int, *kinds: int) -> list[int]:
    answers = [alp.ask("AlpSeqInquire", device, sequence, kind) for kind in kinds]
    assert [code for code, _ in answers] == [0] * len(kinds)
    return [value for _, value in answers]


# Timing (3.10)


@pytest.mark.parametrize(
    ("times", "picture", "illuminate", "pulse"),
    [
        ((60, 200, 0, 0, 0), 200, 60, 60),
        ((60, 200, 100, 0, 0), 200, 60, 160),
        ((60, 200, 100, 7, 0), 200, 60, 7),
        ((156, 200, 0, 0, 0), 200, 156, 156),
    ],
)
def test_in_normal_mode_a_synch_pulse_lasts_for_delay_and_illumination(
    times: tuple[int, ...], picture: int, illuminate: int, pulse: int
) -> None:
    """Section 3.10: the default width is SynchDelay + Illuminate. Section 3.5: picture time = on time + off time."""
    alp = Client()
    device = alp.device()
    sequence = _normal_sequence(alp, device)
    assert alp("AlpSeqTiming", device, sequence, *times) == 0
    told = _told(alp, device, sequence, PICTURE, ILLUMINATE, DELAY, PULSE, ON, OFF)
    assert told == [picture, illuminate, times[2], pulse, illuminate, picture - illuminate]


def test_uninterrupted_a_synch_pulse_lasts_for_the_illumination_and_a_picture_is_never_off() -> None:
    """Section 3.10: the default width is Illuminate, whatever the delay."""
    alp = Client()
    device = alp.device()
    sequence = alp.sequence(device, 2)
    assert alp("AlpSeqTiming", device, sequence, 150, 200, 1000, 0, 30) == 0
    told = _told(alp, device, sequence, PICTURE, ILLUMINATE, DELAY, PULSE, TRIGGER_DELAY, ON, OFF)
    assert told == [200, 150, 1000, 150, 30, 200, 0]


def test_uninterrupted_an_illumination_longer_than_the_picture_is_ignored() -> None:
    """As a public wrapper of the library found; in normal mode it is refused."""
    alp = Client()
    device = alp.device()
    sequence = alp.sequence(device, 2)
    assert alp("AlpSeqTiming", device, sequence, 500, 50, 0, 10, 0) == 0
    assert _told(alp, device, sequence, PICTURE, ON, OFF) == [50, 50, 0]
    assert alp("AlpSeqTiming", device, _normal_sequence(alp, device), 500, 200, 0, 10, 0) == INVALID


@pytest.mark.parametrize(
    ("times", "code"),
    [
        ((157, 200, 0, 10, 0), INVALID),
        ((156, 200, 0, 199, 0), 0),
        ((156, 200, 0, 200, 0), INVALID),
        ((44, 88, 0, 10, 0), 0),
        ((44, 87, 0, 10, 0), INVALID),
        ((0, 10_000_000, 130_000, 10, 0), 0),
        ((0, 10_000_000, 130_001, 10, 0), INVALID),
        ((-1, 200, 0, 10, 0), INVALID),
        ((0, 200, -1, 10, 0), INVALID),
        ((0, 200, 0, -1, 0), INVALID),
        ((0, 200, 0, 10, -1), INVALID),
    ],
)
def test_normal_mode_keeps_44_us_of_darkness_and_every_time_in_its_range(times: tuple[int, ...], code: int) -> None:
    """Section 3.10: picture >= illuminate + 44, pulse < picture, delay from 0 to 130,000 us, picture to 10 s."""
    alp = Client()
    device = alp.device()
    assert alp("AlpSeqTiming", device, _normal_sequence(alp, device), *times) == code


def test_a_timing_that_is_refused_leaves_the_one_before_it() -> None:
    alp = Client()
    device = alp.device()
    sequence = alp.sequence(device, 2, picture_us=60, pulse_us=12)
    assert alp("AlpSeqTiming", device, sequence, 0, 43, 5, 10, 0) == INVALID
    assert _told(alp, device, sequence, PICTURE, DELAY, PULSE) == [60, 0, 12]


def test_an_illumination_alone_makes_the_shortest_picture_that_holds_it() -> None:
    """Section 3.10: 100 us and the dark phase of 44 in normal mode; 100 uninterrupted."""
    alp = Client()
    device = alp.device()
    normal, uninterrupted = _normal_sequence(alp, device), alp.sequence(device, 1)
    for sequence in (normal, uninterrupted):
        assert alp("AlpSeqTiming", device, sequence, 100, 0, 0, 10, 0) == 0
    assert _told(alp, device, normal, PICTURE) == [144]
    assert _told(alp, device, uninterrupted, PICTURE) == [100]


# Sequence controls (3.5)


@pytest.mark.parametrize(
    ("control", "value", "code"),
    [
        (REPEAT, 0, INVALID), (REPEAT, 1, 0), (REPEAT, 1_048_576, 0), (REPEAT, -1, INVALID),
        (FIRST, 3, 0), (FIRST, 4, INVALID), (FIRST, -1, INVALID),
        (LAST, 0, 0), (LAST, 3, 0), (LAST, -1, INVALID),
        (BITNUM, 1, 0), (BITNUM, 0, INVALID),
        (BIN_MODE, NORMAL, 0), (BIN_MODE, UNINTERRUPTED, 0), (BIN_MODE, 2104, INVALID), (BIN_MODE, 2107, INVALID),
        (FORMAT, 0, 0), (FORMAT, 3, 0), (FORMAT, 4, INVALID), (FORMAT, -1, INVALID),
        (FLUT_MODE, 0, 0), (FLUT_MODE, 2, 0), (FLUT_MODE, 3, INVALID), (FLUT_MODE, -1, INVALID),
        (FLUT_OFFSET9, 256, 0), (FLUT_OFFSET9, 255, INVALID), (FLUT_OFFSET9, -256, INVALID),
        (FLUT_ENTRIES9, 0, INVALID), (FLUT_ENTRIES9, 32_768, 0), (FLUT_ENTRIES9, 32_769, INVALID),
        (DMD_LINES, 768 << 16, 0), (DMD_LINES, 1 + (767 << 16), 0), (DMD_LINES, 1 + (768 << 16), INVALID),
        (DMD_LINES, 767 + (1 << 16), 0), (DMD_LINES, 768 + (1 << 16), INVALID), (DMD_LINES, 5, INVALID),
        (BITPLANES, 1, INVALID), (PICNUM, 4, INVALID), (PICTURE, 50, INVALID),
    ],
)  # fmt: skip
def test_a_control_takes_the_values_of_the_sheet_and_keeps_its_own_otherwise(
    control: int, value: int, code: int
) -> None:
    """Section 3.5, on a sequence of four pictures of one bit plane; kinds that can only be inquired are refused."""
    alp = Client()
    device = alp.device()
    sequence = _normal_sequence(alp, device)
    (before,) = _told(alp, device, sequence, control)
    assert alp("AlpSeqControl", device, sequence, control, value) == code
    assert _told(alp, device, sequence, control) == [value if code == 0 else before]


def test_a_sequence_begins_with_the_defaults_of_the_sheet() -> None:
    """Section 3.5: one iteration of all pictures and bit planes, bytes by their highest bits, no table, locked."""
    alp = Client()
    device = alp.device()
    _, sequence = alp.ask("AlpSeqAlloc", device, 3, 7)
    kinds = (
        REPEAT,
        FIRST,
        LAST,
        BITNUM,
        BIN_MODE,
        FORMAT,
        FLUT_MODE,
        2119,
        FLUT_ENTRIES9,
        FLUT_OFFSET9,
        BITPLANES,
        PICNUM,
    )
    assert _told(alp, device, sequence, *kinds) == [1, 0, 6, 3, NORMAL, 0, 0, 0, 1, 0, 3, 7]
    assert _told(alp, device, sequence, MAX_DELAY) == [130_000]


def test_first_and_last_picture_cannot_pass_each_other() -> None:
    alp = Client()
    device = alp.device()
    sequence = _normal_sequence(alp, device)
    assert alp("AlpSeqControl", device, sequence, FIRST, 2) == 0
    assert [alp("AlpSeqControl", device, sequence, LAST, last) for last in (1, 2)] == [INVALID, 0]
    assert [alp("AlpSeqControl", device, sequence, FIRST, first) for first in (3, 2)] == [INVALID, 0]


def test_only_one_bit_plane_can_be_shown_without_interruption() -> None:
    """Section 3.5: BIN_UNINTERRUPTED needs BITNUM = 1, and BITNUM is at most the number of bit planes."""
    alp = Client()
    device = alp.device()
    _, sequence = alp.ask("AlpSeqAlloc", device, 3, 1)
    calls = ((BIN_MODE, UNINTERRUPTED), (BITNUM, 4), (BITNUM, 1), (BIN_MODE, UNINTERRUPTED), (BITNUM, 2), (BITNUM, 1))
    codes = [alp("AlpSeqControl", device, sequence, control, value) for control, value in calls]
    assert codes == [INVALID, INVALID, 0, 0, INVALID, 0]


# Device controls (3.4)


@pytest.mark.parametrize(
    ("control", "value", "code"),
    [
        (2004, 2006, 0), (2004, 2007, 0), (2004, 2005, INVALID), (2004, 2008, INVALID),
        (2005, 2008, 0), (2005, 2009, 0), (2005, 2007, INVALID), (2005, 2010, INVALID),
        (2062, 1, 0), (2062, 2, INVALID), (2062, 15, INVALID), (2062, 16, 0), (2062, 17, 0), (2062, 18, INVALID),
        (2063, 0, 0), (2063, 100, 0), (2063, 101, INVALID), (2063, -1, INVALID),
        (2064, 1, 0), (2064, 2, INVALID),
        (2078, 1, 0), (2078, 2, 0), (2078, 3, INVALID),
        (2000, 1, INVALID), (2021, 4, INVALID),
    ],
)  # fmt: skip
def test_a_device_control_takes_the_values_of_the_sheet(control: int, value: int, code: int) -> None:
    """Section 3.4. What is only told, such as serial number and DMD type, cannot be set."""
    alp = Client()
    device = alp.device()
    _, before = alp.ask("AlpDevInquire", device, control)
    assert alp("AlpDevControl", device, control, value) == code
    assert alp.ask("AlpDevInquire", device, control) == (0, value if code == 0 else before)


@pytest.mark.parametrize(
    ("dmd_type", "width", "height"),
    [
        (1, 1024, 768), (2, 1400, 1050), (3, 1920, 1080), (4, 1024, 768), (5, 1024, 768), (6, 1024, 768),
        (7, 1920, 1200), (8, 2560, 1600), (9, 2560, 1600), (10, 1920, 1080), (11, 1920, 1080), (12, 1280, 800),
    ],
)  # fmt: skip
def test_each_dmd_type_has_the_mirrors_of_its_name(dmd_type: int, width: int, height: int) -> None:
    """Section 3.4: XGA, SXGA+, 1080p, WUXGA, WQXGA and WXGA."""
    alp = Client(dmd_type=dmd_type)
    device = alp.device()
    assert [alp.ask("AlpDevInquire", device, kind) for kind in (2021, 2058, 2057)] == [
        (0, dmd_type), (0, width), (0, height)
    ]  # fmt: skip


def test_a_board_forgets_its_controls_when_it_is_freed() -> None:
    """Section 3.4: the level of the PWM output is 0 after an allocation."""
    alp = Client()
    device = alp.device()
    assert alp("AlpDevControl", device, 2063, 60) == 0
    assert alp("AlpDevFree", device) == 0
    assert alp.ask("AlpDevInquire", alp.device(), 2063) == (0, 0)


def test_a_picture_offset_and_load_stay_inside_the_sequence() -> None:
    """Section 3.2: PicLoad 0 is the whole sequence; pictures 0 to 3 are there, and no others."""
    alp = Client()
    device = alp.device()
    sequence = alp.sequence(device, 4)
    one, four = packed(True), packed(True, False, True, False)
    assert alp.put(device, sequence, one, offset=3) == 0
    assert alp.put(device, sequence, one, offset=4) == INVALID
    assert alp.put(device, sequence, one, offset=-1) == INVALID
    assert alp("AlpSeqPut", device, sequence, 0, 0, four.tobytes()) == 0
    assert alp("AlpSeqPut", device, sequence, 0, 5, four.tobytes()) == INVALID
