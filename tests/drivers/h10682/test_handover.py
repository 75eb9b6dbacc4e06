"""Bins go to the caller in order, each once, and the error only after the last good one."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from drivers.h10682.handover import Handover, bins_per_block, collect
from protocols import CounterOverrun, CounterRun
from tests.drivers.h10682.clock import ScriptClock

RUN = CounterRun(n_bins=10, period_s=0.01, latency_s=0.04)


def u32(*values: int) -> np.ndarray[tuple[int], np.dtype[np.uint32]]:
    return np.array(values, np.uint32)


def i64(*values: int) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    return np.array(values, np.int64)


def broken() -> CounterOverrun:
    return CounterOverrun(saw="a gap", expected="none", remedy="look")


def test_edge_times_start_at_zero_and_go_on_over_blocks() -> None:
    handover = Handover(10, tick_s=0.5)
    handover.add(u32(7, 8), i64(2, 4))
    first = handover.take()
    handover.add(u32(9), i64(6))
    second = handover.take()
    assert first.first_bin == 0
    assert first.opening_edge_s is not None
    assert first.opening_edge_s.tolist() == [0.0, 1.0]
    assert first.closing_edge_s == 3.0
    assert second.first_bin == 2
    assert second.opening_edge_s is not None
    assert second.opening_edge_s.tolist() == [3.0]
    assert second.closing_edge_s == 6.0


def test_a_bin_whose_duration_is_not_in_yet_waits() -> None:
    handover = Handover(10, tick_s=1.0)
    handover.add(u32(1, 2, 3), i64(5))
    assert handover.take().counts.tolist() == [1]
    handover.add(u32(), i64(5, 5))
    assert handover.take().counts.tolist() == [2, 3]


def test_after_a_fault_bins_without_a_duration_are_handed_over_without_edge_times() -> None:
    handover = Handover(10, tick_s=1.0)
    handover.add(u32(1, 2, 3), i64(5))
    handover.fail(broken())
    timed, untimed = handover.take(), handover.take()
    assert timed.counts.tolist() == [1]
    assert timed.closing_edge_s == 5.0
    assert untimed.counts.tolist() == [2, 3]
    assert untimed.first_bin == 1
    assert untimed.opening_edge_s is None


def test_bins_beyond_the_run_are_never_handed_over() -> None:
    handover = Handover(2)
    handover.add(u32(1, 2, 3))
    assert handover.take().counts.tolist() == [1, 2]
    assert handover.left == 0
    assert handover.ready == 0


def test_reading_pauses_one_latency_at_a_time_and_ends_at_its_time_out() -> None:
    clock, handover, asked = ScriptClock(), Handover(10), list[int]()
    block = collect(handover, asked.append, run=RUN, clock=clock, timeout_s=0.1)
    assert len(block) == 0
    assert clock.pauses_s == pytest.approx([0.04, 0.04, 0.02])
    assert asked == [2, 1, 1, 1]


def test_half_a_block_is_handed_over_without_a_second_wait() -> None:
    clock, handover = ScriptClock(), Handover(10)
    collect(handover, lambda _least: handover.add(u32(4, 4)), run=RUN, clock=clock, timeout_s=1.0)
    assert clock.pauses_s == []


def test_a_complete_run_is_not_polled_again() -> None:
    clock, handover = ScriptClock(), Handover(1)
    handover.add(u32(4))
    handover.take()

    def never(_least: int) -> None:
        pytest.fail("polled")

    assert len(collect(handover, never, run=RUN, clock=clock, timeout_s=1.0)) == 0


def test_the_fault_comes_when_the_good_bins_are_gone_and_comes_again() -> None:
    clock, handover = ScriptClock(), Handover(10)

    def poll(_least: int) -> None:
        handover.add(u32(5))
        handover.fail(broken())

    assert collect(handover, poll, run=RUN, clock=clock, timeout_s=0.1).counts.tolist() == [5]
    for _ in range(2):
        with pytest.raises(CounterOverrun):
            collect(handover, poll, run=RUN, clock=clock, timeout_s=0.1)


@given(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 5)), max_size=30), st.integers(1, 40))
def test_however_halves_of_bins_arrive_the_blocks_join_up_to_the_same_run(
    arrivals: list[tuple[int, int]], n_bins: int
) -> None:
    handover = Handover(n_bins, tick_s=1.0)
    counts_sent = ticks_sent = 0
    counts: list[int] = []
    edges: list[float] = []
    for n_counts, n_ticks in arrivals:
        handover.add(
            np.arange(counts_sent, counts_sent + n_counts, dtype=np.uint32),
            np.arange(ticks_sent, ticks_sent + n_ticks, dtype=np.int64),
        )
        counts_sent, ticks_sent = counts_sent + n_counts, ticks_sent + n_ticks
        block = handover.take()
        assert block.first_bin == len(counts)
        counts += block.counts.tolist()
        edges += [] if block.opening_edge_s is None else block.opening_edge_s.tolist()
    n = min(counts_sent, ticks_sent, n_bins)
    assert counts == list(range(n))
    assert edges == [k * (k - 1) / 2 for k in range(n)]


def test_without_a_time_out_one_look_takes_what_is_there() -> None:
    clock, handover, asked = ScriptClock(), Handover(10), list[int]()
    assert len(collect(handover, asked.append, run=RUN, clock=clock, timeout_s=0.0)) == 0
    assert (asked, clock.pauses_s) == ([1], [])


def test_what_is_in_hand_is_held_back_for_one_latency_at_most() -> None:
    """One bin at the first look, none after it: of a time-out of a second, one latency of 40 ms is waited."""
    clock, handover = ScriptClock(), Handover(10)
    arriving = iter([u32(4)])

    def poll(_least: int) -> None:
        handover.add(next(arriving, u32()))

    assert collect(handover, poll, run=RUN, clock=clock, timeout_s=1.0).counts.tolist() == [4]
    assert clock.pauses_s == pytest.approx([0.04])


@pytest.mark.parametrize(
    ("latency_s", "period_s", "bins"), [(0.04, 0.01, 4), (0.04, 0.03, 1), (0.01, 0.1, 1), (0.05, 50e-6, 1000)]
)
def test_a_block_is_what_closes_in_one_latency(latency_s: float, period_s: float, bins: int) -> None:
    assert bins_per_block(CounterRun(n_bins=10, period_s=period_s, latency_s=latency_s)) == bins


def test_a_fault_is_noted_only_where_bins_are_missing() -> None:
    handover = Handover(1)
    assert handover.notes == []
    handover.fail(broken())
    handover.fail(CounterOverrun(saw="a later one", expected="none", remedy="look"))
    assert handover.notes == ["the run broke off: saw a gap; expected none. To do: look."]
    handover.add(u32(4))
    handover.take()
    assert handover.notes == []
