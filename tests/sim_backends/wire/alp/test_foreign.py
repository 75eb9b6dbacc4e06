"""Call sequences of foreign clients, with what they expect: the README example of ALP4lib 1.1.0, and who is killed.

ALP4lib passes no argument types: plain Python integers, ``c_long`` by value, and the addresses of its own integers.
"""

import ctypes
from pathlib import Path

import numpy as np
import pytest

from protocols import BenchContext
from sim_backends.bench import OpticalBench, SceneSettings
from sim_backends.wire.alp import AlpEmulatorSettings, AlpLibrary, open_library
from tests.sim_backends.wire.alp.client import Client
from tests.sim_backends.wire.alp.test_projection import Screen


def test_the_readme_example_of_alp4lib_shows_black_and_white_for_20_ms_each_until_it_is_halted() -> None:
    """One bit in normal mode, one byte a pixel (0 and 255), only a picture time, endless, DevHalt, SeqFree, DevFree."""
    screen = Screen()
    library = Client(screen).library
    device, sequence, told = ctypes.c_ulong(0), ctypes.c_long(0), ctypes.c_long(0)
    assert library.AlpDevAlloc(ctypes.c_long(0), 0, ctypes.byref(device)) == 0
    sizes: list[int] = []
    for inquiry in (2021, 2058, 2057):
        assert library.AlpDevInquire(device, inquiry, ctypes.byref(told)) == 0
        sizes.append(told.value)
    assert sizes == [4, 1024, 768]
    assert library.AlpSeqAlloc(device, ctypes.c_long(1), ctypes.c_long(2), ctypes.byref(sequence)) == 0
    pictures = np.concatenate([np.zeros(768 * 1024), np.full(768 * 1024, 255)]).astype(np.uint8)
    data = pictures.ctypes.data_as(ctypes.c_void_p)
    assert library.AlpSeqPut(device, sequence, ctypes.c_long(0), ctypes.c_long(0), data) == 0
    times = (ctypes.c_long(value) for value in (0, 20_000, 0, 0, 0))
    assert library.AlpSeqTiming(device, sequence, *times) == 0
    assert library.AlpProjStartCont(device, sequence) == 0
    screen.clock.sleep_s(10.0)
    lit = [bool(picture.any()) for picture in screen.pictures(4)]
    assert lit == [False, True, False, True]
    assert len(screen.edges(0, screen.clock.now_s())) == 10.0 / 0.02
    for call in (library.AlpDevHalt(device), library.AlpSeqFree(device, sequence), library.AlpDevFree(device)):
        assert call == 0


def test_its_inquiry_of_the_projection_with_a_sequence_too_many_is_refused() -> None:
    """ALP4lib 1.1.0 passes the sequence before the kind of inquiry, which C takes for the kind (fact sheet 3.11)."""
    alp = Client()
    device = alp.device()
    sequence = alp.sequence(device, 1)
    assert alp("AlpProjInquire", device, sequence, ctypes.byref(ctypes.c_int32())) == 1005


@pytest.mark.parametrize("code", [1001, 1011, 1012])
def test_a_board_let_go_of_a_moment_ago_may_not_be_there_yet(code: int) -> None:
    alp = Client(reallocation_s=0.5, reallocation_code=code)
    device = alp.device()
    assert alp("AlpDevFree", device) == 0
    assert alp.ask("AlpDevAlloc", 0, 0)[0] == code
    alp.bench.clock.sleep_s(0.5)
    assert alp.ask("AlpDevAlloc", 0, 0)[0] == 0


def test_a_killed_owner_leaves_the_board_allocated_until_it_is_switched_off(tmp_path: Path) -> None:
    """Each library is one process; the first never frees the board."""

    def process() -> AlpLibrary:
        settings = AlpEmulatorSettings(owner_file=Path("v7000.owner"))
        bench = OpticalBench(SceneSettings())
        return open_library(settings, BenchContext(clock=bench.clock, scene=bench, folder=tmp_path))

    device = ctypes.c_uint32()
    killed, after = process(), process()
    assert killed.AlpDevAlloc(0, 0, ctypes.byref(device)) == 0
    assert after.AlpDevAlloc(0, 0, ctypes.byref(device)) == 1004
    (tmp_path / "v7000.owner").unlink()
    assert after.AlpDevAlloc(0, 0, ctypes.byref(device)) == 0
    assert after.AlpDevFree(device) == 0
    assert process().AlpDevAlloc(0, 0, ctypes.byref(device)) == 0
