"""Limits of a counter refuse by their figures; a block of counts refuses arrays that contradict each other."""

import re
from typing import Any

import numpy as np
import pytest

from protocols import CountBlock, CounterLimits, CounterRun, PlanError, ProtocolViolation

LIMITS = CounterLimits(max_sync_rate_hz=20e3, max_count_rate_hz=5e6, dead_time_s=20e-9, max_bins=10)
TWO = np.array([5, 7], np.uint32)
EDGES = np.array([0.0, 50e-6])


def test_a_run_at_both_limits_is_taken() -> None:
    LIMITS.check_run(CounterRun(n_bins=10, period_s=50e-6), "pmt")


def test_the_rounding_of_a_period_is_no_excess() -> None:
    """1 / (1 / 44 us) is above 44 us by one bit of the last place, and so may the rate be."""
    limits = LIMITS.model_copy(update={"max_sync_rate_hz": 1 / (44e-6 * (1 + 1e-15))})
    limits.check_sync_rate(44e-6 * (1 - 1e-15), "pmt")


def test_too_many_sync_edges_a_second_are_refused_with_both_numbers() -> None:
    with pytest.raises(PlanError, match=r"pmt: saw 25000 sync edges a second; expected at most 20000\."):
        LIMITS.check_run(CounterRun(n_bins=1, period_s=40e-6), "pmt")


def test_a_run_longer_than_the_counter_is_refused() -> None:
    with pytest.raises(PlanError, match=r"pmt: saw a run of 11 patterns; expected at most 10 patterns a run\."):
        LIMITS.check_run(CounterRun(n_bins=11, period_s=50e-6), "pmt")


def test_a_counter_without_a_longest_run_takes_any() -> None:
    LIMITS.model_copy(update={"max_bins": None}).check_bins(10**9, "pmt")


@pytest.mark.parametrize(
    ("fields", "saw", "expected"),
    [
        ({"counts": TWO.astype(np.int64)}, "shape (2,) and type int64", "uint32"),
        ({"counts": TWO.reshape(1, 2)}, "shape (1, 2) and type uint32", "(n,)"),
        ({"first_bin": -1}, "first_bin = -1", "0 or more"),
        ({"suspect": np.array([True])}, "a mask of shape (1,)", "one bool a bin"),
        ({"suspect": np.array([0, 1])}, "type int64", "one bool a bin"),
        ({"opening_edge_s": EDGES}, "opening edges without a closing edge", "both, or neither"),
        ({"closing_edge_s": 1e-4}, "a closing edge without opening edges", "both, or neither"),
        ({"opening_edge_s": EDGES[:1], "closing_edge_s": 1e-4}, "opening edges of shape (1,)", "one float64 a bin"),
        ({"opening_edge_s": TWO, "closing_edge_s": 9.0}, "type uint32", "one float64 a bin"),
        ({"opening_edge_s": EDGES[::-1], "closing_edge_s": 1e-4}, "go back", "never fall"),
        ({"opening_edge_s": EDGES, "closing_edge_s": 49e-6}, "go back", "never fall"),
        ({"opening_edge_s": np.array([np.nan, 0.0]), "closing_edge_s": 1e-4}, "not numbers", "never fall"),
        ({"opening_edge_s": EDGES, "closing_edge_s": np.nan}, "not numbers", "never fall"),
    ],
)
def test_a_block_that_contradicts_itself_is_refused(fields: dict[str, Any], saw: str, expected: str) -> None:
    good: dict[str, Any] = {"first_bin": 0, "counts": TWO}
    with pytest.raises(ProtocolViolation, match=re.escape(saw)) as refused:
        CountBlock(**(good | fields))
    assert expected in refused.value.expected
    assert "driver" in refused.value.remedy


def test_bins_of_no_length_are_for_the_aligner_to_judge() -> None:
    """A bounce within one tick gives two edges at the same time."""
    block = CountBlock(0, TWO, np.zeros(2), 0.0)
    assert len(block) == 2


def test_an_empty_block_has_no_closing_edge() -> None:
    nothing = np.empty(0, np.uint32)
    assert len(CountBlock(7, nothing, np.empty(0))) == len(CountBlock(7, nothing)) == 0
    with pytest.raises(ProtocolViolation, match="closing edge"):
        CountBlock(7, nothing, np.empty(0), 1.0)


def test_uint32_counts_are_photons_and_float64_are_light() -> None:
    assert CountBlock(0, TWO).photon_counts
    assert not CountBlock(0, TWO.astype(np.float64)).photon_counts
