"""Blocks into frames."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from instrument.live.frames import FrameAssembler
from protocols import Floats, InputError
from tests.instrument.live.streams import block


def _pushed(assembler: FrameAssembler, first: int, values: Floats) -> Floats:
    return np.concatenate(list(assembler.whole(block(first, values))))


@given(cuts=st.lists(st.integers(0, 60), max_size=8))
def test_frames_do_not_depend_on_how_the_stream_is_cut(cuts: list[int]) -> None:
    stream = np.arange(60.0)
    assembler = FrameAssembler(6)
    edges = [0, *sorted(cuts), 60]
    pieces = [_pushed(assembler, a, stream[a:b]) for a, b in itertools.pairwise(edges)]
    assert np.array_equal(np.concatenate(pieces), stream.reshape(10, 6))
    assert assembler.frames_dropped == 0


def test_dropped_patterns_become_nan_and_each_frame_they_touch_is_counted_once() -> None:
    """Patterns 8 and 9 of frame 1, then 11 to 18: the end of frame 1 again, all of frame 2, the first of frame 3."""
    assembler = FrameAssembler(6)
    assert len(_pushed(assembler, 0, np.ones(8))) == 1
    _pushed(assembler, 10, np.ones(1))
    assert assembler.frames_dropped == 1
    frames = _pushed(assembler, 19, np.ones(5))
    assert assembler.frames_dropped == 3
    assert np.isnan(frames).tolist() == [[False] * 2 + [True] * 2 + [False] + [True], [True] * 6, [True] + [False] * 5]


def test_values_that_are_not_valid_become_nan() -> None:
    from dataclasses import replace

    assembler = FrameAssembler(6)
    doubtful = replace(block(0, np.ones(6)), valid=np.array([True, True, False, True, True, True]))
    assert np.isnan(np.concatenate(list(assembler.whole(doubtful)))).tolist() == [
        [False, False, True, False, False, False]
    ]


def test_a_long_gap_comes_in_pieces_of_bounded_size() -> None:
    assembler = FrameAssembler(6)
    pieces = list(assembler.whole(block(6 * 10_000, np.ones(6))))
    assert [len(piece) for piece in pieces] == [4096, 4096, 1808, 1]
    assert assembler.frames_dropped == 10_000


def test_a_block_from_the_past_is_refused() -> None:
    assembler = FrameAssembler(6)
    _pushed(assembler, 0, np.ones(12))
    with pytest.raises(InputError, match="starts at pattern 6; expected pattern 12"):
        _pushed(assembler, 6, np.ones(6))
