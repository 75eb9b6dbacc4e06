"""Afterpulses and spikes."""

import math

import numpy as np
import pytest

from sim_backends.bench.pulses import afterpulses, with_spikes
from tests.sim_backends.projector import all_on, bench_with, pixel, show

T_S = 50e-6


def test_a_count_has_an_afterpulse_with_its_probability() -> None:
    """100 counts and 2 % of them again; the bin before the first had 100 too."""
    counted = np.full(20_000, 100)
    found = afterpulses(counted, 100.0, np.full(20_000, T_S), probability=0.02, delay_s=1e-6, seed=[1, 0])
    assert found.mean() == pytest.approx(2.0, abs=5 * math.sqrt(2 / 20_000))
    assert found.var() == pytest.approx(2.0 * 0.98, rel=0.05)


def test_what_comes_after_the_end_of_a_bin_is_in_the_next() -> None:
    """A delay of 5 us in 50: the part 0.1 (1 - exp(-10)) = 0.1 of the afterpulses goes over. Every third bin has counts."""
    n = 30_000
    counted = np.tile([1000, 0, 0], n // 3)
    found = afterpulses(counted, 0.0, np.full(n, T_S), probability=0.1, delay_s=5e-6, seed=[1, 0]).reshape(-1, 3)
    assert found.mean(axis=0) == pytest.approx([90.0, 10.0, 0.0], abs=5 * math.sqrt(90 / (n // 3)))
    assert (found[:, 2] == 0).all()


def test_a_long_delay_in_a_short_bin_puts_all_into_the_next() -> None:
    found = afterpulses(np.array([10_000, 0]), 0.0, np.full(2, 1e-9), probability=0.1, delay_s=1e-3, seed=[1, 0])
    assert found[0] <= 2
    assert found[1] == pytest.approx(1000, abs=5 * math.sqrt(900))


def test_the_first_bin_of_a_stretch_has_those_of_the_bin_before() -> None:
    first = [
        int(afterpulses(np.zeros(2, np.int64), 1000.0, np.full(2, T_S), probability=0.1, delay_s=5e-6, seed=[s, 0])[0])
        for s in range(2000)
    ]
    assert np.mean(first) == pytest.approx(10.0, abs=5 * math.sqrt(10 / 2000))


def test_afterpulses_make_counts_vary_more_than_chance_alone() -> None:
    """A pair of counts at a time with probability p: mean N (1 + p), variance N (1 + 3 p), in bins of the same light."""
    noise = {
        "kind": "poisson",
        "peak_counts": 400.0,
        "afterpulse_probability": 0.1,
        "afterpulse_delay_s": 1e-8,
        "seed": 1,
    }
    bench = bench_with(object="square", object_height_px=8, start_px=(8.0, 8.0), noise=noise)
    show(bench, [all_on()], times=20_000)
    counts = bench.counts(0, 20_000).astype(float)
    assert counts.mean() == pytest.approx(440.0, rel=2e-3)
    assert counts.var() == pytest.approx(400.0 * 1.3, rel=0.05)


def test_the_bench_takes_the_light_of_the_picture_before_a_stretch() -> None:
    """512 bins a stretch: pattern 511 is lit, all others dark, and of its 1e6 counts 1 % of 2 % lie in bin 512."""
    noise = {
        "kind": "poisson",
        "peak_counts": 1e6,
        "afterpulse_probability": 0.02,
        "afterpulse_delay_s": 5e-7,
        "seed": 1,
    }
    bench = bench_with(object="square", object_height_px=8, start_px=(8.0, 8.0), noise=noise)
    show(bench, [pixel(0, 0)] * 511 + [all_on()] + [pixel(0, 0)] * 3)
    assert bench.counts(511, 3).astype(float).tolist() == pytest.approx([1e6 * (1 + 0.02 * 0.99), 200, 0], abs=5e3)
    assert float(bench.counts(512, 1)[0]) == pytest.approx(200, abs=5 * math.sqrt(200))
    assert bench.counts(510, 1)[0] == 0


def test_photons_are_the_same_ones_with_and_without_afterpulses() -> None:
    def counts(probability: float) -> np.ndarray[tuple[int, ...], np.dtype[np.int64]]:
        noise = {"kind": "poisson", "dead_time_s": 2e-8, "afterpulse_probability": probability, "seed": 1}
        bench = bench_with(object="disc", noise=noise)
        show(bench, [all_on()], times=600)
        return bench.counts(0, 600).astype(np.int64)

    added = counts(1e-3) - counts(0.0)
    assert added.min() == 0
    assert 0 < added.sum() < 600


def test_single_bins_are_far_too_high() -> None:
    values = np.arange(1.0, 10_001.0)
    found = with_spikes(values, 0.01, 100.0, [3, 0]) / values
    assert set(found.round(9).tolist()) == {1.0, 100.0}
    assert (found > 1).sum() == pytest.approx(100, abs=5 * 10)


def test_counts_with_spikes_stay_counts_of_32_bits() -> None:
    counts = np.array([3, 2**31], np.uint32)
    found = with_spikes(counts, 1.0, 2.5, [3, 0])
    assert found.dtype == np.uint32
    assert found.tolist() == [8, 2**32 - 1]  # 7.5 to the even neighbour
    assert with_spikes(counts, 0.0, 2.5, [3, 0]).tolist() == counts.tolist()


def test_spikes_are_the_same_in_whatever_blocks_they_are_read_and_repeat_with_their_seed() -> None:
    def spikes(seed: int, block: int) -> list[int]:
        noise = {"kind": "pixel", "sigma": 0.0, "seed": seed}
        bench = bench_with(object="disc", object_height_px=6, start_px=(8.0, 8.0), noise=noise, spike_probability=0.01)
        show(bench, [all_on()], times=2048)
        read = [bench.counts(first, block) for first in range(0, 2048, block)]
        found = np.concatenate(read)
        assert found.max() == pytest.approx(10 * found.min())
        return np.flatnonzero(found > 2 * found.min()).tolist()

    assert spikes(1, 2048) == spikes(1, 64)
    assert spikes(1, 2048) != spikes(2, 2048)
    assert len(spikes(1, 2048)) == pytest.approx(20.5, abs=5 * 4.5)
