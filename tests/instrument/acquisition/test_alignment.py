"""Bins find their patterns by the hardware's edge times."""

import itertools

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from instrument.acquisition import AlignedBlock, Aligner
from protocols import CountBlock, CounterOverrun, Floats

PERIOD_S = 50e-6
MANY = 100_000


def block(edges: Floats, counts: list[float], first: int = 0) -> CountBlock:
    return CountBlock(first, np.array(counts, np.float64), edges[:-1], float(edges[-1]))


def joined(blocks: list[AlignedBlock]) -> tuple[list[float], list[bool]]:
    values = np.concatenate([b.values for b in blocks])
    return values.tolist(), np.concatenate([b.valid for b in blocks]).tolist()


def test_regular_edges_keep_their_order() -> None:
    placed = Aligner(PERIOD_S, MANY).place(block(np.arange(5, dtype=np.float64) * PERIOD_S, [10, 20, 30, 40]))
    assert placed.values.tolist() == [10, 20, 30, 40]
    assert placed.valid.all()


def test_a_lost_edge_joins_two_patterns_and_later_ones_stay_in_place() -> None:
    edges = np.array([0, 1, 3, 4, 5], np.float64) * PERIOD_S  # the edge that opens pattern 2 is lost
    placed = Aligner(PERIOD_S, MANY).place(block(edges, [10, 50, 40, 50]))
    np.testing.assert_array_equal(placed.values, [10, 50, np.nan, 40, 50])
    assert placed.valid.tolist() == [True, False, False, True, True]
    assert placed.gaps.tolist() == [2]


def test_a_bounce_splits_a_bin_and_its_pieces_are_added_up() -> None:
    edges = np.array([0, 1, 1.02, 2, 3], np.float64) * PERIOD_S
    placed = Aligner(PERIOD_S, MANY).place(block(edges, [10, 1, 19, 30]))
    assert placed.values.tolist() == [10, 20, 30]
    assert placed.valid.tolist() == [True, False, True]
    assert placed.doubles.tolist() == [1]


def test_an_edge_in_the_middle_of_a_period_is_surplus() -> None:
    edges = np.array([0, 1, 1.5, 2, 3], np.float64) * PERIOD_S
    placed = Aligner(PERIOD_S, MANY).place(block(edges, [10, 10, 10, 30]))
    assert placed.values.tolist() == [10, 20, 30]


def test_a_bounce_across_two_blocks_is_seen() -> None:
    aligner = Aligner(PERIOD_S, MANY)
    first = aligner.place(block(np.array([0, 1, 1.02], np.float64) * PERIOD_S, [10, 1]))
    second = aligner.place(block(np.array([1.02, 2, 3], np.float64) * PERIOD_S, [19, 30], first=2))
    assert joined([first, second]) == ([10, 20, 30], [True, False, True])


def test_a_late_edge_that_is_not_a_whole_period_late_is_irregular_and_the_next_are_good_again() -> None:
    edges = np.array([0, 1, 2.4, 3.4, 4.4], np.float64) * PERIOD_S
    placed = Aligner(PERIOD_S, MANY).place(block(edges, [1, 2, 3, 4]))
    assert placed.valid.tolist() == [True, False, True, True]
    assert placed.irregular.tolist() == [1]


def test_a_clock_that_is_one_pattern_off_over_the_run_loses_no_pattern() -> None:
    """150 ppm over 10,000 patterns are one and a half patterns: counted from the start, the last would be misplaced."""
    edges = np.arange(10_001, dtype=np.float64) * PERIOD_S * (1 + 150e-6)
    placed = Aligner(PERIOD_S, MANY).place(block(edges, list(range(10_000))))
    assert placed.valid.all()
    assert placed.values[-1] == 9_999


def test_without_edge_times_bins_are_taken_in_order_and_doubtful_ones_are_masked() -> None:
    suspect = np.array([False, True, False])
    placed = Aligner(PERIOD_S, MANY).place(CountBlock(0, np.array([1, 2, 3], np.uint32), suspect=suspect))
    assert placed.valid.tolist() == [True, False, True]
    assert placed.edge_time_s is None


@given(
    lost=st.sets(st.integers(1, 29), max_size=5),
    cuts=st.sets(st.integers(1, 24), max_size=6),
    ppm=st.floats(-200, 200),
)
def test_light_is_neither_lost_nor_made_and_cuts_do_not_matter(lost: set[int], cuts: set[int], ppm: float) -> None:
    kept = [k for k in range(31) if k not in lost]
    edges = np.array(kept, np.float64) * PERIOD_S * (1 + ppm * 1e-6)
    light = np.array([float(sum(range(a, b))) for a, b in itertools.pairwise(kept)])
    bounds = sorted({0, len(light), *(c for c in cuts if c < len(light))})
    aligner = Aligner(PERIOD_S, MANY)
    blocks = [
        aligner.place(CountBlock(a, light[a:b], edges[a:b], float(edges[b]))) for a, b in itertools.pairwise(bounds)
    ]
    values, valid = joined(blocks)
    assert len(values) == 30
    assert np.nansum(values) == sum(range(30))
    assert [k for k, good in enumerate(valid) if good] == [k for k in range(30) if k not in lost and k + 1 not in lost]


def test_bins_whose_edge_times_have_stopped_keep_their_counts_and_are_masked() -> None:
    aligner = Aligner(PERIOD_S, MANY)
    timed = aligner.place(block(np.arange(3, dtype=np.float64) * PERIOD_S, [10, 20]))
    blind = aligner.place(CountBlock(2, np.array([30.0, 40.0])))
    assert joined([timed, blind]) == ([10, 20, 30, 40], [True, True, False, False])


@pytest.mark.parametrize(
    ("first", "saw"),
    [(4, "bins 2 to 3 are missing"), (1, "bin 1 came again"), (0, "bins 0 to 1 came again")],
)
def test_a_lost_or_repeated_block_is_refused_and_what_came_before_stays(first: int, saw: str) -> None:
    aligner = Aligner(PERIOD_S, 100)
    kept = aligner.place(CountBlock(0, np.array([10, 20], np.uint32)))
    with pytest.raises(CounterOverrun, match=f"begins at bin {first}: {saw}; expected bin 2"):
        aligner.place(CountBlock(first, np.array([30, 40], np.uint32)))
    assert kept.values.tolist() == [10, 20]
    assert aligner.patterns == 2
    assert aligner.place(CountBlock(2, np.array([30, 40], np.uint32))).first_pattern == 2


def test_what_comes_after_the_last_pattern_has_no_place() -> None:
    """Five bins for a run of three patterns, then two more: a lost edge beyond the end is none."""
    aligner = Aligner(PERIOD_S, 3)
    edges = np.array([0, 1, 2, 3, 5, 6], np.float64) * PERIOD_S
    first = aligner.place(block(edges, [10, 20, 30, 40, 50]))
    assert (first.first_pattern, first.values.tolist(), first.beyond) == (0, [10, 20, 30], 3)
    assert first.gaps.tolist() == []
    assert aligner.patterns == 3
    later = aligner.place(block(edges[:3], [60, 70], 5))
    assert (later.first_pattern, later.values.tolist(), later.beyond) == (3, [], 2)
    assert later.edge_time_s is not None
    assert len(later.edge_time_s) == 0
