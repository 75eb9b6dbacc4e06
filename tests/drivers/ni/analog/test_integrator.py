"""The arithmetic of bins from samples, against figures by hand and against a loop."""

from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.ni.analog.integrator import Integrator
from protocols import Floats


def integrator(settle: int = 1) -> Integrator:
    return Integrator(high_v=1.5, low_v=1.0, settle_samples=settle, limit_v=9.9)


def sync_of(n: int, edges: list[int]) -> Floats:
    sync = np.zeros(n)
    sync[edges] = 3.3
    return sync


def test_a_bin_is_the_mean_behind_its_settling_up_to_the_next_edge() -> None:
    """Edges at 2, 6 and 9: bins 2..5 and 6..8, the first sample of each left out."""
    signal = np.array([9.0, 9.0, 5.0, 1.0, 2.0, 3.0, 7.0, 4.0, 6.0, 8.0])
    closed = integrator().feed(signal, sync_of(10, [2, 6, 9]))
    assert closed.values_v.tolist() == [2.0, 5.0]
    assert closed.edges.tolist() == [2, 6, 9]
    assert not closed.overloaded.any()


def test_light_before_the_first_edge_and_behind_the_last_is_no_bin() -> None:
    closing = integrator()
    assert len(closing.feed(np.ones(5), sync_of(5, [2])).values_v) == 0
    assert len(closing.feed(np.ones(5), np.zeros(5)).values_v) == 0
    assert closing.feed(np.ones(3), sync_of(3, [1])).edges.tolist() == [2, 11]
    assert closing.edges_seen == 2


def test_a_sync_that_is_high_from_the_start_is_no_edge() -> None:
    closing = integrator()
    closing.feed(np.ones(4), np.full(4, 3.3))
    assert closing.edges_seen == 0


def test_noise_on_the_sync_below_the_hysteresis_is_no_second_edge() -> None:
    """It falls to 1.2 V, which is below the threshold and above 1.0 V."""
    closing = integrator()
    closing.feed(np.ones(7), np.array([0.0, 3.3, 1.2, 3.3, 0.9, 1.4, 1.5]))
    assert closing.edges_seen == 2


def test_an_overload_marks_its_bin_and_no_other() -> None:
    """Also in the settling, for a preamplifier that was saturated does not settle in time."""
    signal = np.array([9.9, 1.0, 1.0, 9.9, 1.0, 1.0, 1.0, -9.9, 1.0])
    closed = integrator().feed(signal, sync_of(9, [0, 3, 6]) * [0, 1, 1, 1, 1, 1, 1, 1, 1] + 0)
    assert closed.overloaded.tolist() == [True]
    later = integrator().feed(signal[:8], sync_of(8, [1, 5, 7]))
    assert later.overloaded.tolist() == [True, False]


def test_a_bin_that_is_too_short_to_settle_has_its_last_sample() -> None:
    closed = integrator(settle=5).feed(np.array([0.0, 1.0, 2.0, 3.0]), sync_of(4, [1, 3]))
    assert closed.values_v.tolist() == [2.0]


def test_the_noise_is_that_of_the_samples_and_steps_between_bins_do_not_count() -> None:
    """White noise of 10 mV on levels that jump by 1 V: 100 bins of 20 samples of which 18 are taken."""
    random = np.random.default_rng(3)
    levels = np.tile([0.0, 1.0], 50).repeat(20)
    signal = np.append(levels + random.normal(0, 0.01, 2000), 0.0)
    closing = integrator(settle=2)
    closing.feed(signal, sync_of(2001, list(range(0, 2001, 20))) * (np.arange(2001) > 0))
    assert closing.sample_noise_v == pytest.approx(0.01, rel=0.05)
    assert closing.value_noise_v == pytest.approx(0.01 / np.sqrt(18), rel=0.05)


def test_nothing_is_estimated_from_nothing() -> None:
    assert integrator().sample_noise_v is None
    assert integrator().value_noise_v is None


@settings(max_examples=50, deadline=None)
@given(
    st.lists(st.integers(2, 9), min_size=2, max_size=12), st.lists(st.integers(1, 30), max_size=6), st.integers(0, 4)
)
def test_pieces_of_any_size_give_the_same_bins(lengths: list[int], pieces: list[int], settle: int) -> None:
    edges = np.cumsum([1, *lengths])
    signal = np.random.default_rng(1).normal(size=int(edges[-1]) + 3)
    sync = sync_of(len(signal), edges.tolist())
    expected = [float(np.mean(signal[min(a + settle, b - 1) : b])) for a, b in pairwise(edges)]
    closing = integrator(settle)
    values: list[float] = []
    at = 0
    for piece in [*pieces, len(signal)]:
        values += closing.feed(signal[at : at + piece], sync[at : at + piece]).values_v.tolist()
        at += piece
    assert values == pytest.approx(expected, abs=1e-9)
    assert closing.edges_seen == len(edges)
