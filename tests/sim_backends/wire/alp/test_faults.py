"""Each fault of dlp7000.md 8, as a caller sees it."""

import numpy as np
import pytest
from pydantic import ValidationError

from sim_backends.bench import VirtualClock
from sim_backends.wire.alp import AlpEmulatorSettings
from sim_backends.wire.alp.codes import FUNCTIONS
from sim_backends.wire.alp.library import SIGNATURES
from tests.sim_backends.wire.alp.client import Client, packed
from tests.sim_backends.wire.alp.test_projection import Screen


@pytest.mark.parametrize(("kind", "code"), [("unplug", 1012), ("power-loss", 1001)])
def test_a_board_that_goes_away_answers_nothing_else_any_more(kind: str, code: int) -> None:
    """From the start of the projection on, every call gives the same code, and no edge comes."""
    screen = Screen()
    alp = Client(screen, faults=[{"kind": kind, "at": "AlpProjStart"}])
    device = alp.device()
    sequence = alp.sequence(device, 2)
    assert alp("AlpProjStart", device, sequence) == code
    assert [alp("AlpProjHalt", device), alp("AlpSeqFree", device, sequence), alp("AlpDevFree", device)] == [code] * 3
    assert screen.shown == []


def test_a_missing_dmd_reads_255_and_looks_like_1080p() -> None:
    """A driver that goes on would upload the wrong geometry (3.4)."""
    alp = Client(faults=[{"kind": "no-dmd"}])
    device = alp.device()
    asked = [alp.ask("AlpDevInquire", device, kind) for kind in (2021, 2058, 2057)]
    assert asked == [(0, 255), (0, 1920), (0, 1080)]


def test_somebody_else_may_hold_the_board() -> None:
    """1004 once; the next attempt succeeds."""
    alp = Client(faults=[{"kind": "other-owner"}])
    assert alp.ask("AlpDevAlloc", 0, 0)[0] == 1004
    assert alp.ask("AlpDevAlloc", 0, 0)[0] == 0


def test_memory_may_be_full_whatever_the_sum_says() -> None:
    """1007 at the first AlpSeqAlloc."""
    alp = Client(faults=[{"kind": "memory-full"}])
    assert alp.ask("AlpSeqAlloc", alp.device(), 1, 1) == (1007, 0xDEAD)


def test_a_halt_from_elsewhere_aborts_an_upload() -> None:
    """1009 after half of the pictures; the board is idle and the upload can be repeated."""
    screen = Screen()
    alp = Client(screen, faults=[{"kind": "halt-during-put"}])
    device = alp.device()
    sequence = alp.sequence(device, 4)
    assert alp.put(device, sequence, packed(True, True, True, True)) == 1009
    assert alp.ask("AlpDevInquire", device, 2002) == (0, 1102)
    assert alp("AlpProjStart", device, sequence) == 0
    assert [int(picture[0, 0]) for picture in screen.pictures()] == [255, 255, 0, 0]
    assert alp("AlpDevHalt", device) == 0
    assert alp.put(device, sequence, packed(True, True, True, True)) == 0


def test_any_call_may_give_any_code() -> None:
    """The second AlpSeqTiming is refused with a code that no rule gives."""
    alp = Client(faults=[{"kind": "refuse", "at": "AlpSeqTiming", "nth": 2, "code": 1020}])
    device = alp.device()
    sequence = alp.sequence(device, 1)
    assert alp("AlpSeqTiming", device, sequence, 0, 50, 0, 10, 0) == 1020
    assert alp("AlpSeqTiming", device, sequence, 0, 50, 0, 10, 0) == 0


@pytest.mark.parametrize(
    ("slots", "steps", "order"), [("pass", [1, 3, 1], [0, 1, 1, 1, 4, 5]), ("close-up", [1, 1, 1], [0, 1, 4, 5])]
)
def test_lost_frames_are_silent(slots: str, steps: list[int], order: list[int]) -> None:
    """Two of six pictures and their edges are missing, and every code is 0. Their time passes, or it does not."""
    screen = Screen()
    alp = Client(screen, faults=[{"kind": "lost-frames", "first": 2, "count": 2, "slots": slots}])
    device = alp.device()
    sequence = alp.sequence(device, 6)
    assert alp("AlpProjStart", device, sequence) == 0
    assert alp("AlpProjWait", device) == 0
    edges = screen.edges(0, screen.clock.now_s()).time_s
    np.testing.assert_allclose(np.diff(edges), np.array(steps) * screen.shown[-1].picture_time_s)
    assert screen.shown[-1].play_order.tolist() == order


def test_wrong_rows_shift_the_picture() -> None:
    """What was row 0 is row 3."""
    screen = Screen()
    alp = Client(screen, faults=[{"kind": "wrong-rows", "rows": 3}])
    device = alp.device()
    sequence = alp.sequence(device, 1)
    picture = packed(False)
    picture[0, 0] = 255
    assert alp.put(device, sequence, picture) == 0
    assert alp("AlpProjStart", device, sequence) == 0
    assert np.flatnonzero(screen.pictures()[0].any(axis=1)).tolist() == [3]


def test_pictures_never_uploaded_may_show_what_the_memory_held() -> None:
    """With ``uploads_cleared = false`` every second mirror is on."""
    screen = Screen()
    alp = Client(screen, uploads_cleared=False)
    device = alp.device()
    sequence = alp.sequence(device, 1)
    assert alp("AlpProjStart", device, sequence) == 0
    assert set(np.unique(screen.pictures()[0])) == {0xAA}


def test_a_halt_from_another_thread_aborts_an_upload() -> None:
    """The upload lets other calls through while the bytes go over the line: here AlpDevHalt, half a second into it."""
    screen = Screen()
    alp = Client(screen, usb_bytes_per_s=1e6)
    device = alp.device()
    sequence = alp.sequence(device, 8)

    class Halting(VirtualClock):
        def sleep_s(self, duration_s: float) -> None:
            super().sleep_s(duration_s)
            if self.now_s() > 0.5:
                assert alp("AlpDevHalt", device) == 0

    screen.keep_time_by(Halting())
    assert alp.put(device, sequence, packed(*[True] * 8)) == 1009
    assert 0.5 < screen.clock.now_s() < 0.7


def test_a_fault_at_a_function_that_does_not_exist_is_refused() -> None:
    """A misspelt name would be a fault that never strikes."""
    assert set(SIGNATURES) == FUNCTIONS
    with pytest.raises(ValidationError, match="AlpProjStart"):
        AlpEmulatorSettings.model_validate({"faults": [{"kind": "unplug", "at": "AlpProjBegin"}]})
