"""What is counted on the bench: photons, noise and seeds, and blocks in which the counts are read."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from protocols import InputError, WrongState
from tests.sim_backends.projector import SIZE, all_on, bench_with, dot, pixel, save, show, values

RANDOM = np.random.default_rng(11)


def test_peak_counts_are_the_photons_of_an_all_lit_picture() -> None:
    noise = {"kind": "poisson", "peak_counts": 400.0, "seed": 1}
    bench = bench_with(object="square", object_height_px=8, start_px=(8.0, 8.0), noise=noise)
    left = all_on()
    left[:, 8:] = 0
    show(bench, [all_on(), left], times=2000)
    counts = bench.counts(0, 4000)
    assert counts.dtype == np.uint32
    assert counts[::2].mean() == pytest.approx(400.0, abs=4 * 20 / np.sqrt(2000))
    assert counts[1::2].mean() == pytest.approx(200.0, abs=4 * 14.2 / np.sqrt(2000))


def test_photon_counting_needs_light_in_the_field_at_the_first_picture() -> None:
    bench = bench_with(object="square", object_height_px=2, start_px=(-50.0, 8.0), noise={"kind": "poisson"})
    with pytest.raises(InputError, match="no light of 'square' in the field"):
        show(bench, [all_on()])


def test_pixel_noise_counts_lit_pixels_on_the_image_grid(tmp_path: Path) -> None:
    bench = bench_with(tmp_path, object=save(tmp_path, dot(4, 5)), noise={"kind": "pixel", "sigma": 0.1, "seed": 5})
    show(bench, [all_on(), pixel(0, 0)], times=5000)
    counts = bench.counts(0, 10_000)
    assert counts[::2].std() == pytest.approx(0.1 * SIZE, rel=0.03)
    assert counts[1::2].std() == pytest.approx(0.1, rel=0.03)


@pytest.mark.parametrize("kind", ["pixel", "poisson"])
def test_the_seed_makes_a_run_repeatable_to_the_bit(kind: str) -> None:
    def run(seed: int) -> list[float]:
        bench = bench_with(object="disc", noise={"kind": kind, "seed": seed})
        return values(bench, [all_on()] * 50)

    assert run(1) == run(1)
    assert run(1) != run(2)


def test_the_same_run_again_gives_the_same_counts() -> None:
    bench = bench_with(object="disc", noise={"kind": "poisson", "dead_time_s": 20e-9})
    assert values(bench, [all_on()] * 50) == values(bench, [all_on()] * 50)


MANY = [RANDOM.integers(0, 2, (SIZE, SIZE), dtype=np.uint8) for _ in range(7)]


@settings(max_examples=10, deadline=None)
@given(cuts=st.lists(st.integers(1, 1399), max_size=6), kind=st.sampled_from(["pixel", "poisson"]))
def test_counts_do_not_depend_on_the_blocks_in_which_they_are_read(cuts: list[int], kind: str) -> None:
    noise = {"kind": kind, "seed": 3}
    at_once, bench = bench_with(object="ring", noise=noise), bench_with(object="ring", noise=noise)
    show(at_once, MANY, times=200)
    show(bench, MANY, times=200)
    borders = [0, *sorted(set(cuts)), 1400]
    blocks = [(first, last - first) for first, last in pairwise(borders)]
    read = {first: bench.counts(first, n) for first, n in reversed(blocks)}
    assert np.concatenate([read[first] for first, _ in blocks]).tolist() == at_once.counts(0, 1400).tolist()


def test_counts_are_a_copy_that_a_reader_may_spoil() -> None:
    bench = bench_with(object="disc")
    first = values(bench, [all_on()] * 3)
    bench.counts(0, 3)[:] = -1
    assert bench.counts(0, 3).tolist() == first


def test_bins_beyond_the_last_edge_are_refused() -> None:
    bench = bench_with(object="disc")
    assert bench.counts(0, 0).tolist() == []
    with pytest.raises(WrongState, match="before anything was shown"):
        bench.counts(0, 1)
    show(bench, [all_on()] * 3)
    with pytest.raises(WrongState, match="bins 0 to 2, between 4 edges"):
        bench.counts(2, 2)
