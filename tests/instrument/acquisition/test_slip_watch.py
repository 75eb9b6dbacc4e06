"""Slips are found piece by piece as they are found in a whole run, and what is held does not grow with the run."""

import numpy as np
import pytest

from instrument.acquisition import slip_watch
from instrument.acquisition.slip_watch import SlipWatch
from instrument.plan import Plan
from instrument.schemes import scheme_of
from instrument.session import simulate
from protocols import Floats

PLAN = Plan(frames=400, image_size=16, superpixel=4)
SCHEME = scheme_of(PLAN)


@pytest.fixture(scope="module")
def light() -> Floats:
    """``(2400,)`` counts of a run without faults."""
    return simulate(PLAN, {"noise": {"kind": "poisson", "peak_counts": 2000.0, "seed": 3}}).values.ravel()


def watched(values: Floats, patterns: int = 2400, block: int = 70) -> SlipWatch:
    watch = SlipWatch(SCHEME, patterns, 6)
    for first in range(0, len(values), block):
        watch.see(values[first : first + block], np.ones(-(-patterns // 6), bool), photon_counts=True)
    return watch


def found(watch: SlipWatch, patterns: int = 2400) -> list[tuple[int, int, int]]:
    slips = watch.slips(np.ones(-(-patterns // 6), bool), photon_counts=True)
    assert slips is not None
    assert len(slips.sure) == len(slips.shift)
    return [(part.first_frame, part.end_frame, part.shift) for part in slips.segments]


@pytest.mark.parametrize("piece", [8192, 100])
def test_a_lost_edge_and_one_gained_later_are_found_in_pieces_as_in_the_whole(
    light: Floats, piece: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Without pattern 700 all come early from frame 116 on; a surplus value at 1799 puts them in step again from frame 299 on."""
    monkeypatch.setattr(slip_watch, "PIECE", piece)
    monkeypatch.setattr(slip_watch, "_AGAIN", 20)
    values = np.concatenate([light[:700], light[701:1800], light[1799:]])
    parts = found(watched(values))
    assert [shift for _, _, shift in parts] == [0, -1, 0]
    (_, lost, _), (_, gained, _), (_, end, _) = parts
    assert abs(lost - 116) <= 1
    assert abs(gained - 299) <= 1
    assert end == 400


def test_a_run_in_step_is_one_segment_whatever_the_pieces(light: Floats, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(slip_watch, "PIECE", 100)
    monkeypatch.setattr(slip_watch, "_AGAIN", 20)
    assert found(watched(light)) == [(0, 400, 0)]
    assert found(watched(light[:605])) == [(0, 100, 0)]  # a frame that was begun is no frame
    assert watched(light[:5]).slips(np.ones(400, bool), photon_counts=True) is None


def test_no_more_is_held_of_a_longer_run() -> None:
    held = [watched(np.ones(0), patterns).held_bytes for patterns in (600, 10**6, 10**8)]
    assert held == [4 * 606, 4 * 6 * (8192 + 1), 4 * 6 * (8192 + 1)]
