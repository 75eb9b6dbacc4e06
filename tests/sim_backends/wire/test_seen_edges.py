"""What an armed counter sees of the bench: each edge once, and the photons of each bin."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocols import BenchContext, InputError
from sim_backends.bench import OpticalBench
from sim_backends.wire.seen_edges import SeenEdges, photon_bench_of
from tests.sim_backends.projector import PICTURE_S, all_on, bench_with, show

PHOTONS = {"kind": "poisson", "peak_counts": 250.0, "seed": 3}


def lit_bench(pictures: int = 4, **scene: object) -> OpticalBench:
    bench = bench_with(object="disc", noise=PHOTONS, **scene)
    show(bench, [all_on()] * pictures, start_s=1.0)
    return bench


def test_each_edge_closes_the_bin_before_it_and_the_first_closes_none() -> None:
    bench = lit_bench()
    edges = SeenEdges(bench, 0.0)
    time_s, photons = edges.take(2.0)
    assert time_s.tolist() == pytest.approx([1.0 + k * PICTURE_S for k in range(5)])
    assert photons.tolist() == [0, *bench.counts(0, 4).tolist()]
    assert len(edges.take(2.0)[0]) == 0


def test_an_edge_at_the_moment_of_arming_is_seen_and_an_earlier_one_is_not() -> None:
    bench = lit_bench()
    second_s = bench.edges(1, 9.0).time_s[0]
    assert len(SeenEdges(bench, second_s).take(2.0)[0]) == 4
    assert len(SeenEdges(bench, np.nextafter(second_s, 2.0)).take(2.0)[0]) == 3


@settings(max_examples=30, deadline=None)
@given(looks_s=st.lists(st.floats(0.9999, 1.0011), max_size=8))
def test_looking_oftener_changes_nothing(looks_s: list[float]) -> None:
    bench = lit_bench(20)
    edges = SeenEdges(bench, 0.0)
    parts = [edges.take(look_s) for look_s in [*sorted(looks_s), 2.0]]
    assert np.concatenate([time_s for time_s, _ in parts]).tolist() == bench.edges(0, 2.0).time_s.tolist()
    assert np.concatenate([photons for _, photons in parts]).tolist() == [0, *bench.counts(0, 20).tolist()]


def test_a_counter_that_stays_armed_sees_the_next_projection_too() -> None:
    bench = lit_bench(2)
    edges = SeenEdges(bench, 0.0)
    assert len(edges.take(2.0)[0]) == 3
    bench.clock.advance_to(2.0)
    show(bench, [all_on()] * 3, start_s=3.0)
    assert edges.time_of(1, 9.0) == 3.0
    time_s, photons = edges.take(4.0)
    assert time_s[0] == 3.0
    assert photons.tolist() == [0, *bench.counts(0, 3).tolist()]


def test_the_time_of_a_coming_edge_is_known_up_to_a_limit() -> None:
    edges = SeenEdges(lit_bench(), 0.0)
    assert edges.time_of(3, 2.0) == pytest.approx(1.0 + 2 * PICTURE_S)
    assert edges.time_of(3, 1.0 + PICTURE_S) is None
    assert edges.time_of(6, 2.0) is None


def test_a_bench_that_counts_no_photons_is_refused() -> None:
    with pytest.raises(InputError, match=r'noise of kind \'pixel\'.*choose noise = \{ kind = "poisson" \}'):
        photon_bench_of(BenchContext(scene=bench_with(noise={"kind": "pixel"})), "pmt")
    with pytest.raises(InputError, match=r"no \[scene\] table"):
        photon_bench_of(BenchContext(), "pmt")
