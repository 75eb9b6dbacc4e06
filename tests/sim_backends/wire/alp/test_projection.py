"""What reaches the mirrors and the counter, and when."""

import ctypes

import numpy as np
import pytest

from protocols import Bytes, PixelGrid
from sim_backends.bench import BenchClock, OpticalBench, Projection, SceneSettings
from tests.sim_backends.wire.alp.client import Client, packed


class Screen(OpticalBench):
    """An optical bench that keeps what it was told to show."""

    def __init__(self, **scene: object) -> None:
        super().__init__(SceneSettings.model_validate(scene))
        self.shown: list[Projection] = []

    def keep_time_by(self, clock: BenchClock) -> None:
        """Take another clock."""
        self._clock = clock

    def show(self, projection: Projection) -> None:
        self.shown.append(projection)
        super().show(projection)

    def pictures(self, most: int | None = None) -> list[Bytes]:
        """``(rows, columns / 8)`` of each picture of the last projection, ``most`` of them."""
        return [self.shown[-1].mirrors(int(plane)) for plane in self.shown[-1].play_order[:most]]


def _numbered(n: int) -> Bytes:
    """Picture k has k in its first byte: ``(n, 768, 128)``."""
    pictures = np.zeros((n, 768, 128), np.uint8)
    pictures[:, 0, 0] = np.arange(n)
    return pictures


def _first_bytes(screen: Screen, most: int | None = None) -> list[int]:
    return [int(picture[0, 0]) for picture in screen.pictures(most)]


def _started(screen: Screen, n: int, **settings: object) -> tuple[Client, int, int]:
    alp = Client(screen, **settings)
    device = alp.device()
    sequence = alp.sequence(device, n)
    assert alp.put(device, sequence, _numbered(n)) == 0
    return alp, device, sequence


def test_every_format_puts_the_same_picture_on_the_mirrors() -> None:
    """Packed top down, packed bottom up, one byte a pixel by bit 7, and by bit 0 (3.8): bit 7 is the leftmost pixel."""
    lit = np.zeros((768, 1024), np.uint8)
    lit[2, 9] = lit[700, 1023] = 1
    want = np.packbits(lit, axis=-1)
    assert want[2, 1] == 0x40
    data = {0: lit * 128, 1: lit, 2: want, 3: want[::-1].copy()}
    for data_format, picture in data.items():
        screen = Screen()
        alp = Client(screen)
        device = alp.device()
        sequence = alp.sequence(device, 1)
        assert alp("AlpSeqControl", device, sequence, 2110, data_format) == 0
        assert alp("AlpSeqPut", device, sequence, 0, 1, picture.ctypes.data_as(ctypes.c_void_p)) == 0
        assert alp("AlpProjStart", device, sequence) == 0
        np.testing.assert_array_equal(screen.pictures()[0], want)


def test_first_and_last_frame_and_repeat_choose_the_pictures() -> None:
    """Frames 1 to 2, three times."""
    screen = Screen()
    alp, device, sequence = _started(screen, 4)
    for control, value in ((2102, 2), (2101, 1), (2100, 3)):
        assert alp("AlpSeqControl", device, sequence, control, value) == 0
    assert alp("AlpProjStart", device, sequence) == 0
    assert _first_bytes(screen) == [1, 2, 1, 2, 1, 2]


@pytest.mark.parametrize(("mode", "control"), [(1, 2325), (2, 2326)])
def test_the_look_up_table_plays_pictures_in_any_order(mode: int, control: int) -> None:
    """In 18-bit mode an entry takes two of the 9-bit slots that FLUT_ENTRIES9 counts (3.5)."""
    screen = Screen()
    alp, device, sequence = _started(screen, 3)
    assert alp.ask("AlpProjInquire", device, 2324) == (0, 32_768)
    assert alp.flut(device, control, 0, [0, 1, 0, 1]) == 0
    assert alp.flut(device, control, 4, [2]) == 0
    for kind, value in ((2118, mode), (2122, 0), (2120, 5 * mode)):
        assert alp("AlpSeqControl", device, sequence, kind, value) == 0
    assert alp("AlpProjStart", device, sequence) == 0
    assert _first_bytes(screen) == [0, 1, 0, 1, 2]


def test_18_bit_entries_reach_pictures_that_9_bits_cannot() -> None:
    """Picture 600 is 600 - 512 = 88 for a 9-bit entry."""
    for mode, control, reached in ((1, 2325, 88), (2, 2326, 600)):
        screen = Screen()
        alp = Client(screen)
        device = alp.device()
        sequence = alp.sequence(device, 700)
        assert alp.flut(device, control, 0, [600]) == 0
        assert alp("AlpSeqControl", device, sequence, 2118, mode) == 0
        assert alp("AlpSeqControl", device, sequence, 2120, mode) == 0
        assert alp("AlpProjStart", device, sequence) == 0
        assert screen.shown[-1].play_order.tolist() == [reached]


def test_a_board_without_look_up_table_says_so() -> None:
    """Every call that is about the table gives 1005."""
    alp = Client(flut_max_entries9=0)
    device = alp.device()
    sequence = alp.sequence(device, 1)
    assert alp.ask("AlpProjInquire", device, 2324)[0] == 1005
    assert alp.flut(device, 2325, 0, [0]) == 1005
    assert alp("AlpSeqControl", device, sequence, 2118, 1) == 1005


def test_the_table_refuses_what_does_not_fit() -> None:
    """Beyond its end, more than 4096 entries at once, and 'all' from an offset (3.7)."""
    alp = Client(flut_max_entries9=8)
    device = alp.device()
    assert alp.flut(device, 2325, 0, [0] * 8) == 0
    assert alp.flut(device, 2325, 1, [0] * 8) == 1005
    assert alp.flut(device, 2326, 0, [0] * 5) == 1005
    assert alp.flut(device, 2325, 1, []) == 1005
    assert alp("AlpProjControlEx", device, 2325, None) == 1006


def test_inversion_and_flips_act_between_memory_and_mirrors() -> None:
    """Mirror (0, 0) lit in memory: upside down it is in the last row, flipped it is the last bit, inverted all but it."""
    expected = {2307: (767, 0, 0x80), 2346: (0, 127, 0x01), 2306: (0, 0, 0x7F)}
    for control, (row, byte, value) in expected.items():
        screen = Screen()
        alp = Client(screen)
        device = alp.device()
        sequence = alp.sequence(device, 1)
        picture = packed(False)
        picture[0, 0, 0] = 0x80
        assert alp.put(device, sequence, picture) == 0
        assert alp("AlpProjControl", device, control, 1) == 0
        assert alp("AlpProjStart", device, sequence) == 0
        assert screen.pictures()[0][row, byte] == value


def test_synch_delay_puts_the_edge_before_the_picture_and_low_polarity_its_end() -> None:
    """Display is edge + SynchDelay; on an active-low line the edge that rises comes a pulse width later."""
    for polarity, delay_us in ((2006, 20.0), (2007, 10.0)):
        screen = Screen()
        alp, device, sequence = _started(screen, 3)
        assert alp("AlpSeqTiming", device, sequence, 0, 50, 20, 10, 0) == 0
        assert alp("AlpDevControl", device, 2004, polarity) == 0
        assert alp("AlpProjStart", device, sequence) == 0
        assert screen.shown[-1].sync_delay_s * 1e6 == pytest.approx(delay_us)
        first_edge_s = float(screen.edges(0, 1.0).time_s[0])
        assert (screen.shown[-1].start_s - first_edge_s) * 1e6 == pytest.approx(delay_us)


@pytest.mark.parametrize(
    ("first_synch", "edges", "shown"),
    [("with-picture-0", 3, [0, 1, 2]), ("extra", 4, [0, 0, 1, 2]), ("missing", 2, [1, 2])],
)
def test_the_first_synch_pulse_is_a_setting(first_synch: str, edges: int, shown: list[int]) -> None:
    """Bench question 5 of the sheet: N pulses, one more before picture 0, or none for it."""
    screen = Screen()
    alp, device, sequence = _started(screen, 3, first_synch=first_synch)
    assert alp("AlpProjStart", device, sequence) == 0
    assert len(screen.edges(0, 1.0)) == edges
    assert _first_bytes(screen) == shown


def test_progress_counts_down() -> None:
    """Section 3.7: iterations to be done and frames left; after 5 of 8 pictures, the second of two rounds has 3 left."""
    screen = Screen()
    alp, device, sequence = _started(screen, 4)
    assert alp("AlpSeqControl", device, sequence, 2100, 2) == 0
    words = (ctypes.c_uint32 * 9)()
    assert alp("AlpProjStart", device, sequence) == 0
    screen.clock.advance_to(screen.shown[-1].start_s + 5.5 * 50e-6)
    assert alp("AlpProjInquireEx", device, 2318, ctypes.byref(words)) == 0
    queue_id, shown, waiting, iterations, _, frames, picture_us, of, flags = words
    assert (queue_id, shown, waiting, iterations, frames, picture_us, of, flags) == (1, sequence, 0, 1, 3, 50, 4, 0)
    screen.clock.sleep_s(1.0)
    assert alp("AlpProjInquireEx", device, 2318, ctypes.byref(words)) == 0
    assert words[8] == 1


@pytest.mark.parametrize(("function", "shown"), [("AlpDevHalt", 11), ("AlpProjHalt", 12)])
def test_a_halt_of_the_device_ends_pictures_at_once_and_one_of_the_projection_after_the_iteration(
    function: str, shown: int
) -> None:
    """In the middle of the 11th picture of an endless sequence of 4: three iterations are 12 pictures."""
    screen = Screen()
    alp, device, sequence = _started(screen, 4)
    assert alp("AlpProjStartCont", device, sequence) == 0
    screen.clock.advance_to(screen.shown[-1].start_s + 10.5 * 50e-6)
    assert alp(function, device) == 0
    edges = screen.edges(0, 1.0)
    assert (len(edges), edges.finished) == (shown, True)


def test_a_start_replaces_an_endless_projection_when_its_iteration_is_over() -> None:
    """Both endless: A shows 8 of 4 pictures, then B begins (quoted from the maker's manual)."""
    screen = Screen()
    alp, device, first = _started(screen, 4)
    second = alp.sequence(device, 2)
    assert alp.put(device, second, _numbered(2) + 100) == 0
    assert alp("AlpProjStartCont", device, first) == 0
    start_s = screen.shown[-1].start_s
    screen.clock.advance_to(start_s + 5.5 * 50e-6)
    assert alp("AlpProjStartCont", device, second) == 0
    screen.clock.advance_to(start_s + 7.9 * 50e-6)
    assert alp("AlpSeqFree", device, first) == 1008
    screen.clock.advance_to(start_s + 8.1 * 50e-6)
    assert alp.ask("AlpProjInquire", device, 2400) == (0, 1200)
    assert screen.shown[-1].start_s == pytest.approx(start_s + 8 * 50e-6)
    assert _first_bytes(screen, 3) == [100, 101, 100]
    assert alp("AlpSeqFree", device, first) == 0


def test_in_queue_mode_an_endless_projection_keeps_the_others_waiting_until_it_is_aborted() -> None:
    """ALP_PROJ_SEQUENCE_QUEUE (3.6): here with two positions; the third start finds none free."""
    screen = Screen()
    alp, device, first = _started(screen, 4, queue_positions=2)
    second = alp.sequence(device, 2)
    assert alp("AlpProjControl", device, 2314, 1) == 0
    assert alp.ask("AlpProjInquire", device, 2316) == (0, 2)
    assert alp("AlpProjStartCont", device, first) == 0
    start_s = screen.shown[-1].start_s
    assert [alp("AlpProjStart", device, second) for _ in range(3)] == [0, 0, 1002]
    assert alp.ask("AlpProjInquire", device, 2317) == (0, 0)
    screen.clock.advance_to(start_s + 9.5 * 50e-6)
    assert alp.ask("AlpProjInquire", device, 2317) == (0, 0)
    assert alp("AlpProjControl", device, 2320, 0) == 0
    screen.clock.advance_to(start_s + 12.5 * 50e-6)
    assert alp.ask("AlpProjInquire", device, 2317) == (0, 1)
    screen.clock.advance_to(start_s + 14.5 * 50e-6)
    assert alp.ask("AlpProjInquire", device, 2317) == (0, 2)
    assert alp("AlpProjWait", device) == 0
    assert screen.clock.now_s() == pytest.approx(start_s + 16 * 50e-6)


def test_lines_of_a_picture_are_overwritten_and_the_others_kept() -> None:
    """AlpSeqPutEx, tAlpLinePut {1, picture 1, 1 picture, line 5, 2 lines} (3.7), in every data format."""
    lines = np.zeros((2, 768, 1024), np.uint8)
    lines[0, :2, :8] = 1
    for data_format, body in (
        (0, lines[0, :2] * 128), (1, lines[0, :2]), (2, np.packbits(lines[0, :2], axis=-1)),
        (3, np.packbits(lines[0, :2], axis=-1)),
    ):  # fmt: skip
        screen = Screen()
        alp, device, sequence = _started(screen, 2)
        assert alp("AlpSeqControl", device, sequence, 2110, data_format) == 0
        stretch = (ctypes.c_int32 * 5)(1, 1, 1, 5, 2)
        data = np.ascontiguousarray(body)
        pointer = data.ctypes.data_as(ctypes.c_void_p)
        assert alp("AlpSeqPutEx", device, sequence, ctypes.byref(stretch), pointer) == 0
        assert alp("AlpProjStart", device, sequence) == 0
        lit = [np.argwhere(picture).tolist() for picture in screen.pictures()]
        assert lit == [[], [[0, 0], *([[761, 0], [762, 0]] if data_format == 3 else [[5, 0], [6, 0]])]]
        too_many = (ctypes.c_int32 * 5)(1, 1, 1, 767, 2)
        assert alp("AlpSeqPutEx", device, sequence, ctypes.byref(too_many), pointer) == 1005


def test_a_picture_of_normal_mode_is_shown_for_its_whole_time() -> None:
    """The optical bench has no dark phase; edges come at the picture time."""
    screen = Screen()
    alp = Client(screen)
    device = alp.device()
    _, sequence = alp.ask("AlpSeqAlloc", device, 1, 2)
    assert alp("AlpSeqControl", device, sequence, 2110, 2) == 0
    assert alp("AlpSeqTiming", device, sequence, 0, 20_000, 0, 0, 0) == 0
    assert alp.put(device, sequence, packed(False, True)) == 0
    assert alp("AlpProjStart", device, sequence) == 0
    assert [bool(picture.any()) for picture in screen.pictures()] == [False, True]
    assert np.diff(screen.edges(0, 1.0).time_s).tolist() == pytest.approx([0.02])


def test_an_abort_lets_the_iteration_or_the_picture_end() -> None:
    """ABORT_SEQUENCE ends after four pictures, ABORT_FRAME after the one that is shown; both may come while running."""
    for control, pictures in ((2320, 4), (2321, 2)):
        screen = Screen()
        alp, device, sequence = _started(screen, 4)
        assert alp("AlpProjStartCont", device, sequence) == 0
        start_s = screen.shown[-1].start_s
        screen.clock.advance_to(start_s + 1.5 * 50e-6)
        assert alp("AlpProjControl", device, control, 0) == 0
        screen.clock.advance_to(start_s + (pictures - 0.1) * 50e-6)
        assert alp.ask("AlpProjInquire", device, 2400) == (0, 1200)
        screen.clock.advance_to(start_s + (pictures + 0.01) * 50e-6)
        assert alp.ask("AlpProjInquire", device, 2400) == (0, 1201)
        assert len(screen.edges(0, 1.0)) == pictures


def test_a_second_start_waits_for_the_first() -> None:
    """Legacy queue: one waiting position (3.6); the second begins where the first ended."""
    screen = Screen()
    alp, device, sequence = _started(screen, 2)
    assert alp("AlpProjStart", device, sequence) == 0
    assert alp.ask("AlpProjInquire", device, 2317) == (0, 1)
    assert alp("AlpProjStart", device, sequence) == 0
    assert alp.ask("AlpProjInquire", device, 2317) == (0, 0)
    first_s = screen.shown[-1].start_s
    assert alp("AlpProjWait", device) == 0
    assert len(screen.shown) == 2
    assert screen.shown[-1].start_s == pytest.approx(first_s + 100e-6)


def test_an_asynchronous_abort_and_a_floating_dmd_end_at_once() -> None:
    """ABORT_ASYNC needs no frame to end; DMD_POWER_FLOAT lets no projection start until it is resumed."""
    screen = Screen()
    alp, device, sequence = _started(screen, 4)
    assert alp("AlpProjStartCont", device, sequence) == 0
    assert alp("AlpProjControl", device, 2345, 0) == 0
    assert alp.ask("AlpProjInquire", device, 2400) == (0, 1201)
    assert len(screen.edges(0, 1.0)) == 0
    assert alp("AlpDevControl", device, 2064, 1) == 0
    assert alp("AlpProjStart", device, sequence) == 1021
    assert alp("AlpDevControl", device, 2064, 0) == 0
    assert alp("AlpProjStart", device, sequence) == 0


def test_a_reset_queue_forgets_what_waits() -> None:
    """RESET_QUEUE leaves the running one alone (3.6)."""
    screen = Screen()
    alp, device, sequence = _started(screen, 2)
    assert [alp("AlpProjStart", device, sequence), alp("AlpProjStart", device, sequence)] == [0, 0]
    assert alp("AlpProjControl", device, 2319, 0) == 0
    assert alp("AlpProjWait", device) == 0
    assert len(screen.shown) == 1


def test_rows_outside_the_loaded_ones_stay_dark() -> None:
    """SEQ_DMD_LINES: 48 rows from row 24."""
    screen = Screen()
    alp = Client(screen)
    device = alp.device()
    sequence = alp.sequence(device, 1)
    assert alp("AlpSeqControl", device, sequence, 2125, 24 + (48 << 16)) == 0
    assert alp.put(device, sequence, packed(True)) == 0
    assert alp("AlpProjStart", device, sequence) == 0
    assert np.flatnonzero(screen.pictures()[0].any(axis=1)).tolist() == list(range(24, 72))


def test_slave_mode_without_edges_never_ends() -> None:
    """7.1 item 6: no trigger is connected, so the projection stays active and AlpProjWait gives up with 1999."""
    alp = Client(patience_s=10.0)
    device = alp.device()
    sequence = alp.sequence(device, 2)
    assert alp("AlpProjControl", device, 2300, 2302) == 0
    assert alp("AlpProjStart", device, sequence) == 0
    alp.bench.clock.sleep_s(5.0)
    assert alp.ask("AlpProjInquire", device, 2400) == (0, 1200)
    assert alp("AlpProjWait", device) == 1999
    assert alp("AlpDevHalt", device) == 0


def test_a_stalled_line_of_the_scene_keeps_the_projection_active() -> None:
    """The bench's own fault: the modulator stays on a picture, and never says that it has finished."""
    screen = Screen(faults=[{"kind": "stall", "picture": 1}])
    alp, device, sequence = _started(screen, 4)
    assert alp("AlpProjStart", device, sequence) == 0
    screen.clock.sleep_s(5.0)
    assert alp.ask("AlpProjInquire", device, 2400) == (0, 1200)


def test_light_worked_out_late_is_that_of_the_pictures_that_were_shown() -> None:
    """Planes are kept with the projection: overwriting the sequence afterwards changes no count."""
    bench = OpticalBench(SceneSettings())
    bench.use_grid(PixelGrid(image_size=32, superpixel=2))
    alp = Client(bench)
    device = alp.device()
    sequence = alp.sequence(device, 2)
    alp.put(device, sequence, packed(True, False))
    assert alp("AlpProjStart", device, sequence) == 0
    assert alp("AlpProjWait", device) == 0
    alp.put(device, sequence, packed(False, False))
    assert bench.counts(0, 1)[0] > 0
