"""The call order of dlp7000.md 3.9 and the codes of wrong calls, by the sheet's own numbers."""

import ctypes

import numpy as np
import pytest

from protocols import BenchContext, InputError
from sim_backends.bench import OpticalBench, SceneSettings
from sim_backends.wire.alp import AlpEmulatorSettings
from sim_backends.wire.alp.library import AlpLibrary
from sim_backends.wire.alp.plugin import plugin
from tests.sim_backends.wire.alp.client import Client, packed


def test_the_call_order_of_the_sheet_gives_one_edge_a_picture() -> None:
    """Steps 1 to 12 of section 3.9: three pictures at 50 us are three edges, and two bins of 827 and 0."""
    alp = Client()
    code, device = alp.ask("AlpDevAlloc", 0, 0)
    assert (code, device != 0xFFFFFFFF) == (0, True)
    asked = [alp.ask("AlpDevInquire", device, kind) for kind in (2021, 2058, 2057, 2003, 2002)]
    assert asked == [(0, 4), (0, 1024), (0, 768), (0, 43690), (0, 1102)]
    assert alp("AlpDevControl", device, 2004, 2006) == 0
    assert alp("AlpDevControl", device, 2005, 2009) == 0
    assert alp("AlpProjControl", device, 2300, 2301) == 0
    code, sequence = alp.ask("AlpSeqAlloc", device, 1, 3)
    assert code == 0
    for control, value in ((2110, 2), (2103, 1), (2104, 2106), (2101, 0), (2102, 2), (2100, 1)):
        assert alp("AlpSeqControl", device, sequence, control, value) == 0
    assert alp("AlpSeqTiming", device, sequence, 0, 50, 0, 10, 0) == 0
    asked = [alp.ask("AlpSeqInquire", device, sequence, kind) for kind in (2203, 2211, 2206, 2213)]
    assert asked == [(0, 50), (0, 44), (0, 10), (0, 10_000_000)]
    assert alp.put(device, sequence, packed(True, False, False)) == 0
    assert alp.ask("AlpProjInquire", device, 2400) == (0, 1201)
    assert alp("AlpProjStart", device, sequence) == 0
    assert alp.ask("AlpProjInquire", device, 2400) == (0, 1200)
    assert alp.ask("AlpDevInquire", device, 2002) == (0, 1100)
    started_s = alp.bench.clock.now_s()
    assert alp("AlpProjWait", device) == 0
    assert alp.bench.clock.now_s() == pytest.approx(started_s + 200e-6 + 150e-6)
    edges = alp.bench.edges(0, alp.bench.clock.now_s())
    np.testing.assert_allclose(np.diff(edges.time_s), 50e-6)
    assert (len(edges), edges.finished) == (3, True)
    lit, dark = alp.bench.counts(0, 2)
    assert lit > 0 == dark
    assert alp.ask("AlpProjInquire", device, 2400) == (0, 1201)
    assert [alp("AlpDevHalt", device), alp("AlpSeqFree", device, sequence), alp("AlpDevFree", device)] == [0, 0, 0]


def test_argument_types_can_be_set_as_on_a_loaded_library() -> None:
    """A pointer of the table takes argtypes and restype, converts by them, and stays the same object."""
    alp = Client()
    function = alp.library.AlpDevAlloc
    assert function is alp.library.AlpDevAlloc
    function.argtypes = (ctypes.c_int32, ctypes.c_int32, ctypes.POINTER(ctypes.c_uint32))  # type: ignore[attr-defined]
    device = ctypes.c_uint32()
    assert function(0, 0, ctypes.byref(device)) == 0
    with pytest.raises(ctypes.ArgumentError):
        function("0", 0, ctypes.byref(device))
    with pytest.raises(AttributeError, match="AlpNoSuchThing"):
        _ = alp.library.AlpNoSuchThing


def test_image_data_may_come_in_every_way_that_ctypes_knows() -> None:
    """bytes, c_char_p, a ctypes array and an address all carry the same picture."""
    alp = Client()
    device = alp.device()
    sequence = alp.sequence(device, 1)
    picture = packed(True).tobytes()
    array = (ctypes.c_uint8 * len(picture)).from_buffer_copy(picture)
    for data in (picture, ctypes.c_char_p(picture), array, ctypes.c_void_p(ctypes.addressof(array))):
        assert alp("AlpSeqPut", device, sequence, 0, 1, data) == 0


@pytest.mark.parametrize(
    ("function", "arguments", "code"),
    [
        ("AlpDevAlloc", (99, 0, "out"), 1001),
        ("AlpDevAlloc", (0, 0, "out"), 1004),
        ("AlpDevAlloc", (0, 0, None), 1006),
        ("AlpDevInquire", ("other", 2003, "out"), 1003),
        ("AlpDevInquire", ("device", 9999, "out"), 1005),
        ("AlpDevInquire", ("device", 2003, None), 1006),
        ("AlpDevControl", ("device", 2004, 2008), 1005),
        ("AlpDevControl", ("device", 2063, 101), 1005),
        ("AlpSeqAlloc", ("device", 1, 43690, "out"), 1007),
        ("AlpSeqAlloc", ("device", 9, 1, "out"), 1005),
        ("AlpSeqAlloc", ("device", 1, 0, "out"), 1005),
        ("AlpSeqFree", ("device", "other"), 1006),
        ("AlpSeqControl", ("device", "sequence", 2102, 4), 1005),
        ("AlpSeqControl", ("device", "sequence", 2103, 2), 1005),
        ("AlpSeqControl", ("device", "sequence", 2100, 1_048_577), 1005),
        ("AlpSeqInquire", ("device", "sequence", 9999, "out"), 1005),
        ("AlpSeqTiming", ("device", "sequence", 0, 43, 0, 10, 0), 1005),
        ("AlpSeqTiming", ("device", "sequence", 0, 10_000_001, 0, 10, 0), 1005),
        ("AlpSeqTiming", ("device", "sequence", 0, 50, 0, 50, 0), 1005),
        ("AlpSeqTiming", ("device", "sequence", 51, 50, 0, 10, 0), 0),
        ("AlpSeqTiming", ("device", "sequence", 0, 50, 130_001, 10, 0), 1005),
        ("AlpSeqTiming", ("device", "sequence", 0, 44, 130_000, 43, 0), 0),
        ("AlpSeqPut", ("device", "sequence", 3, 2, "data"), 1005),
        ("AlpSeqPut", ("device", "sequence", 0, 4, None), 1006),
        ("AlpProjControl", ("device", 2300, 2303), 1005),
        ("AlpProjStart", ("device", "other"), 1006),
        ("AlpProjInquireEx", ("device", 9999, "out"), 1005),
        ("AlpProjWait", ("device",), 0),
        ("AlpProjHalt", ("device",), 0),
    ],
)
def test_a_wrong_call_gives_the_code_of_the_sheet(function: str, arguments: tuple[object, ...], code: int) -> None:
    """Sections 3.3, 3.10 and 7.1 on a board with one sequence of four pictures."""
    alp = Client()
    device = alp.device()
    sequence = alp.sequence(device, 4)
    out = ctypes.c_uint32()
    names = {"device": device, "other": 77, "sequence": sequence, "out": ctypes.byref(out), "data": bytes(98_304)}
    given = [names.get(argument, argument) if isinstance(argument, str) else argument for argument in arguments]
    assert alp(function, *given) == code


def test_a_refused_allocation_leaves_the_invalid_id() -> None:
    """dlp7000.md 3.1: ALP_ID outputs are 0xFFFFFFFF after an error."""
    alp = Client()
    device = alp.device()
    assert alp.ask("AlpSeqAlloc", device, 1, 43_691) == (1007, 0xFFFFFFFF)
    assert alp.ask("AlpDevAlloc", 0, 0) == (1004, 0xFFFFFFFF)


def test_the_running_sequence_is_protected() -> None:
    """SeqPut and SeqFree give 1008, ProjControl and DevFree 1002, ProjWait after StartCont 1005."""
    alp = Client()
    device = alp.device()
    sequence = alp.sequence(device, 2)
    alp.put(device, sequence, packed(True, False))
    assert alp("AlpProjStartCont", device, sequence) == 0
    assert alp.put(device, sequence, packed(True)) == 1008
    assert alp("AlpSeqFree", device, sequence) == 1008
    assert alp("AlpProjControl", device, 2306, 1) == 1002
    assert alp("AlpDevFree", device) == 1002
    assert alp("AlpProjWait", device) == 1005
    assert alp("AlpSeqControl", device, sequence, 2119, 1) == 0
    assert alp.put(device, sequence, packed(True)) == 0
    assert alp("AlpProjHalt", device) == 0
    assert alp.ask("AlpProjInquire", device, 2400) == (0, 1200)
    alp.bench.clock.sleep_s(0.001)
    assert alp.ask("AlpProjInquire", device, 2400) == (0, 1201)
    assert alp("AlpDevFree", device) == 1002
    assert [alp("AlpDevHalt", device), alp("AlpDevFree", device)] == [0, 0]
    assert alp("AlpDevHalt", device) == 1003


def test_packed_data_counts_bit_planes_and_other_data_pictures() -> None:
    """Two pictures of three bit planes are six units of packed data, or two of one byte a pixel (3.8)."""
    alp = Client()
    device = alp.device()
    _, sequence = alp.ask("AlpSeqAlloc", device, 3, 2)
    assert alp.ask("AlpDevInquire", device, 2003) == (0, 43_690 - 6)
    grey = np.zeros((2, 768, 1024), np.uint8)
    assert alp.put(device, sequence, grey) == 0
    assert alp.put(device, sequence, grey, offset=1) == 1005
    assert alp("AlpSeqControl", device, sequence, 2110, 2) == 0
    assert alp.put(device, sequence, packed(*[True] * 6)) == 0
    assert alp.put(device, sequence, packed(True), offset=6) == 1005


def test_the_gates_of_the_dynamic_outputs_are_checked() -> None:
    """Period 0 to 16, polarity 0 or 1 (3.7)."""
    alp = Client()
    device = alp.device()
    for struct, code in ((bytes([16, 1, *[1] * 16]), 0), (bytes([17, 1, *[1] * 16]), 1005), (None, 1006)):
        assert alp("AlpDevControlEx", device, 2023, struct) == code
    assert alp("AlpDevControlEx", device, 9999, bytes(18)) == 1005


def test_an_error_inside_the_emulator_is_a_code_too() -> None:
    """Nothing may escape through C: a scene that cannot be lit gives 1999, and is logged."""
    alp = Client(OpticalBench(SceneSettings.model_validate({"noise": {"kind": "poisson"}, "start_px": [-900.0, 0.0]})))
    device = alp.device()
    sequence = alp.sequence(device, 2)
    assert alp("AlpProjStart", device, sequence) == 1999


def test_normal_mode_needs_its_dark_phase() -> None:
    """A timing given before BIN_MODE is that of normal mode: 50 us is too short there, 88 us is not (3.9, 3.10)."""
    alp = Client()
    device = alp.device()
    _, sequence = alp.ask("AlpSeqAlloc", device, 1, 1)
    assert alp("AlpSeqTiming", device, sequence, 0, 50, 0, 10, 0) == 1005
    assert alp("AlpSeqTiming", device, sequence, 0, 88, 0, 10, 0) == 0
    assert alp.ask("AlpSeqInquire", device, sequence, 2215) == (0, 44)
    assert alp("AlpProjStart", device, sequence) == 0
    _, grey = alp.ask("AlpSeqAlloc", device, 2, 1)
    assert alp("AlpProjStart", device, grey) == 1021


def test_without_any_time_the_board_plays_at_30_hz() -> None:
    """All five times ALP_DEFAULT (3.10)."""
    alp = Client()
    device = alp.device()
    sequence = alp.sequence(device, 1)
    assert alp("AlpSeqTiming", device, sequence, 0, 0, 0, 0, 0) == 0
    assert alp.ask("AlpSeqInquire", device, sequence, 2203) == (0, 33_334)


def test_fewer_rows_go_faster() -> None:
    """48 rows from row 24: 720 rows of 40 ns less than 44 us, rounded up."""
    alp = Client()
    device = alp.device()
    sequence = alp.sequence(device, 1)
    assert alp("AlpSeqControl", device, sequence, 2125, 24 + (48 << 16)) == 0
    assert alp.ask("AlpSeqInquire", device, sequence, 2211) == (0, 16)


def test_upload_takes_the_time_of_the_usb_line() -> None:
    """98,304 bytes at 30 MB/s are 3.2768 ms of simulated time."""
    alp = Client()
    device = alp.device()
    sequence = alp.sequence(device, 4)
    before_s = alp.bench.clock.now_s()
    alp.put(device, sequence, packed(True, False, True, False))
    assert alp.bench.clock.now_s() - before_s == pytest.approx(4 * 98_304 / 30e6)


def test_the_plugin_gives_the_function_table_on_the_scene() -> None:
    """It stands on the optical bench of the context, and says so where there is none."""
    bench = OpticalBench(SceneSettings())
    library = plugin.open(AlpEmulatorSettings(), BenchContext(clock=bench.clock, scene=bench))
    assert isinstance(library, AlpLibrary)
    assert library.board.bench is bench
    with pytest.raises(InputError, match=r"\[scene\]"):
        plugin.open(AlpEmulatorSettings(), BenchContext())
