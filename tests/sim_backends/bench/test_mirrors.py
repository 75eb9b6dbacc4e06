"""Mirrors that need time, lose light at their borders, or stand on the wrong side."""

from pathlib import Path

import numpy as np
import pytest

from protocols import Bytes
from sim_backends.bench.mirrors import lagged, remainder
from tests.sim_backends.projector import SIZE, all_on, bench_with, dot, pixel, save, show, values

RANDOM = np.random.default_rng(3)


def test_four_microseconds_at_twenty_kilohertz_are_a_twenty_fifth() -> None:
    assert remainder(4e-6, 0.0, 50e-6) == pytest.approx(0.04)
    assert remainder(12.5e-6, 0.0, 50e-6) == pytest.approx(0.125)


def test_settling_adds_a_quarter_of_its_time() -> None:
    """The real mirrors: (4 / 2 + 8.5 / 4) / 50 = 0.0825."""
    assert remainder(4e-6, 8.5e-6, 50e-6) == pytest.approx(0.0825)
    assert remainder(0.0, 8.5e-6, 50e-6) == pytest.approx(0.0425)


def test_the_crossover_takes_half_of_a_picture_and_both_together_all_of_it_at_most() -> None:
    assert remainder(1.0, 0.0, 50e-6) == 0.5
    assert remainder(1.0, 1.0, 50e-6) == 1.0


def test_an_exponential_approach_loses_its_time_constant() -> None:
    """By adding up the response to a step over a picture: linear over 4 us, then held back with a time constant of 2.125 us."""
    time_s = (np.arange(500_000) + 0.5) * 1e-10
    lag = np.exp(-time_s / 2.125e-6)
    # A first-order lag of a ramp from 0: r(t) - (tau / T_x)(1 - exp(-t / tau)) on the ramp, and a pure decay after it.
    tau, across = 2.125e-6, 4e-6
    on_ramp = time_s / across - tau / across * (1 - lag)
    left_at_end = tau / across * (1 - np.exp(-across / tau))
    after = 1 - left_at_end * np.exp(-(time_s - across) / tau)
    seen = np.where(time_s < across, on_ramp, after).mean()
    assert 1 - seen == pytest.approx(remainder(4e-6, 8.5e-6, 50e-6), abs=1e-6)


def test_before_the_first_picture_all_is_dark() -> None:
    assert lagged(np.array([10.0, 20.0, 0.0]), 0.1).tolist() == pytest.approx([9.0, 19.0, 2.0])


def test_the_part_of_the_picture_before_is_found_by_regression(tmp_path: Path) -> None:
    """y_k - v_k = c (v_(k-1) - v_k), with v from a bench whose mirrors need no time: c to a billionth, without noise."""
    patterns = [RANDOM.integers(0, 2, (SIZE, SIZE), dtype=np.uint8) for _ in range(700)]
    (tmp_path / "path.csv").write_text("t_s,x_px,y_px\n0,0,0\n1,100,50\n")
    scene = {"object": save(tmp_path, RANDOM.random((SIZE, SIZE))), "trajectory": "path.csv"}
    ideal = np.array(values(bench_with(tmp_path, **scene), patterns))
    real = np.array(values(bench_with(tmp_path, **scene, mirror_transition_s=4e-6, mirror_settling_s=8.5e-6), patterns))
    step = ideal[:-1] - ideal[1:]
    assert float(step @ (real - ideal)[1:] / (step @ step)) == pytest.approx(0.0825, abs=1e-9)


# Edges of lit mirrors


def _borders(pattern: Bytes) -> tuple[int, int]:
    """Sides of pixels between lit and dark ones inside the field, and sides of lit pixels at its border."""
    inside = int(
        np.abs(np.diff(pattern.astype(int), axis=0)).sum() + np.abs(np.diff(pattern.astype(int), axis=1)).sum()
    )
    outside = int(pattern[0].sum() + pattern[-1].sum() + pattern[:, 0].sum() + pattern[:, -1].sum())
    return inside, outside


@pytest.mark.parametrize("seed", range(4))
def test_the_sum_of_a_pattern_and_its_complement_falls_by_two_losses_a_border(tmp_path: Path, seed: int) -> None:
    """On an even scene of 0.5: a side of a pixel is two sides of mirrors, each of which has 0.5 / 4 of light.

    Each black-white side loses in the pattern and in its complement, each of the 4 x 16 sides at the border of the field in
    one of them: 0.25 x 0.05 x 0.5 for each. What is left is the even light of 0.5 x 256.
    """
    pattern = np.random.default_rng(seed).integers(0, 2, (SIZE, SIZE), dtype=np.uint8)
    bench = bench_with(tmp_path, object=save(tmp_path, np.full((SIZE, SIZE), 0.5)), edge_loss=0.05)
    bright, dark = values(bench, [pattern, 1 - pattern])
    inside, outside = _borders(pattern)
    a_side = 0.05 * 2 * 0.5 / 4
    assert bright + dark == pytest.approx(128.0 - a_side * (2 * inside + 4 * SIZE))
    assert bright == pytest.approx(0.5 * pattern.sum() - a_side * (inside + outside))


# Mirrors on the wrong side


def test_inverted_mirrors_light_the_detector_by_their_dark_side(tmp_path: Path) -> None:
    scene = RANDOM.random((SIZE, SIZE))
    bench = bench_with(tmp_path, object=save(tmp_path, scene), mirrors_inverted=True)
    pattern = RANDOM.integers(0, 2, (SIZE, SIZE), dtype=np.uint8)
    show(bench, [pattern, all_on()], times=1)
    assert bench.counts(0, 2).tolist() == pytest.approx([(scene * (1 - pattern)).sum(), 0.0])


def test_inverted_mirrors_invert_finer_patterns_and_the_background(tmp_path: Path) -> None:
    fine = np.zeros((2 * SIZE, 2 * SIZE), np.uint8)
    fine[8, 10] = 1
    save(tmp_path, dot(4, 5), "still.npy")
    bench = bench_with(tmp_path, object=save(tmp_path, dot(1, 1)), background="still.npy", mirrors_inverted=True)
    assert values(bench, [fine]) == pytest.approx([1.0 + 0.75])


def test_inverted_mirrors_lose_light_at_borders_to_dark_ones_alone(tmp_path: Path) -> None:
    """All on, which is all dark, but for one pixel: it has four dark sides. All off is lit, far beyond the field: no loss."""
    bench = bench_with(tmp_path, object=save(tmp_path, dot(0, 0)), edge_loss=0.1, mirrors_inverted=True)
    alone = all_on()
    alone[0, 0] = 0
    # Beyond the field mirrors are off, so lit: the pixel in the corner has two dark sides and loses half of 2 x 0.1.
    assert values(bench, [alone, 1 - all_on()]) == pytest.approx([0.9, 1.0])


def test_noise_of_pixels_is_that_of_the_mirrors_that_are_seen() -> None:
    """255 of 256 pixels are off, so lit: sigma 0.1 sqrt(255); and of an all-lit picture nothing is seen, without noise."""
    noise = {"kind": "pixel", "sigma": 0.1, "seed": 5}
    bench = bench_with(object="square", object_height_px=2, start_px=(8.0, 8.0), noise=noise, mirrors_inverted=True)
    show(bench, [pixel(0, 0), all_on()], times=5000)
    counts = bench.counts(0, 10_000)
    assert counts[::2].std() == pytest.approx(0.1 * np.sqrt(255), rel=0.03)
    assert (counts[1::2] == 0).all()
