"""Counts as differences of cumulative samples: across the wrap of 32 bits, in pieces, and after a fault."""

from hypothesis import given
from hypothesis import strategies as st

from drivers.ni.samples import SampledCounter
from tests.drivers.h10682.clock import ScriptClock
from tests.drivers.ni.script import ScriptedTask

WRAP = 2**32


def test_the_fact_sheets_wrap_from_4294967295_to_3_is_4_counts() -> None:
    clock = ScriptClock(time_s=1.0)
    assert SampledCounter(ScriptedTask(clock, [4294967295, 3], [0.0, 0.0])).differences(2).tolist() == [4]


@given(
    start=st.integers(0, WRAP - 1),
    counts=st.lists(st.integers(0, WRAP - 1), max_size=30),
    pieces=st.lists(st.integers(1, 5), max_size=40),
)
def test_any_counts_come_back_from_their_wrapped_sums_in_pieces_of_any_size(
    start: int, counts: list[int], pieces: list[int]
) -> None:
    samples = [start]
    for count in counts:
        samples.append((samples[-1] + count) % WRAP)
    counter = SampledCounter(ScriptedTask(ScriptClock(time_s=1.0), samples, [0.0] * len(samples)))
    got = [d for n in pieces for d in counter.differences(n).tolist()] + counter.rest().tolist()
    assert got == counts


def test_after_a_failed_read_a_counter_is_not_read_across_the_gap() -> None:
    clock = ScriptClock()
    task = ScriptedTask(clock, [1, 2, 3, 4], [0.0] * 4, breaks_after=2)
    clock.sleep_s(1.0)
    counter = SampledCounter(task)
    assert counter.differences(10).tolist() == [1]
    task.breaks_after = None
    assert counter.rest().tolist() == []
    assert counter.fault is not None


def test_what_is_left_in_a_buffer_after_a_fault_is_read_in_pieces() -> None:
    clock = ScriptClock(time_s=1e9)
    counter = SampledCounter(ScriptedTask(clock, list(range(250_000)), [0.0] * 250_000))
    assert counter.rest().tolist() == [1] * 249_999
