"""Rows on an image grid finer than the patterns', against patterns integrated over much finer pixels."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from instrument.patterns import hadamard_order
from instrument.reconstruction import Field, Region, ShiftedHadamard
from instrument.reconstruction.field import acting_walsh
from instrument.reconstruction.walsh_rows import walsh_changes, walsh_rows
from protocols import Floats, Integers, Singles

SIZE, FINE = 8, 40  # pattern pixels, and strips a pattern pixel that places in fortieths cut exactly

places = st.integers(-2 * SIZE * FINE, 2 * SIZE * FINE).map(lambda strips: strips / FINE)


def _strips(field: Field, number: int, place_px: float, first: int, count: int) -> Floats:
    """Integral of a row over each image pixel in pattern pixels, as a sum over strips, the row at each strip's middle."""
    coarse = acting_walsh(Field(field.size, 1, field.edge_loss))[number]
    middle = first + (np.arange(count * FINE) + 0.5) / FINE + place_px
    cell = np.floor(middle).astype(np.int64)
    inside = (cell >= 0) & (cell < field.size)
    seen = np.where(inside, coarse[np.clip(cell, 0, field.size - 1)], 0.0)
    return np.asarray(seen.reshape(count * field.grid, -1).sum(axis=1) / FINE, np.float64)


@given(
    number=st.integers(0, SIZE - 1),
    place=places,
    first=st.integers(0, 3),
    count=st.integers(1, 5),
    field=st.builds(Field, st.just(SIZE), st.sampled_from([1, 2, 4]), st.sampled_from([0.0, 0.07])),
)
def test_an_entry_is_the_integral_of_the_pattern_over_its_pixel(
    number: int, place: float, first: int, count: int, field: Field
) -> None:
    grid = field.grid
    strips = _strips(field, number, place, first, count)
    rows = walsh_rows(field, np.array([number]), np.array([place]), first, count)
    assert rows.shape == (1, count * grid)
    np.testing.assert_allclose(rows[0], strips, atol=3e-6)
    series = np.random.default_rng(number).standard_normal(count * grid)
    changes = walsh_changes(field, np.array([number]), np.array([place]), first, count)
    assert changes.shape == (1, count * grid)
    assert (changes @ np.cumsum(series))[0] == pytest.approx(float(strips @ series), abs=1e-9)


@given(number=st.integers(0, SIZE - 1), whole=st.integers(-20, 20), grid=st.sampled_from([1, 2]))
def test_the_slope_is_a_change_per_pattern_pixel(number: int, whole: int, grid: int) -> None:
    field = Field(SIZE, grid, 0.05)
    place = whole / grid + 0.2
    before, after = (_strips(field, number, place + step, 0, SIZE) for step in (-0.1, 0.1))
    slope = walsh_rows(field, np.array([number]), np.array([place]), 0, SIZE, slope=True)
    np.testing.assert_allclose(slope[0], (after - before) / 0.2, atol=3e-6)


def _dense(pairs: Integers, place_px: Floats, field: Field, region: Region) -> Floats:
    """Rows of a Hadamard pattern at one place each."""
    rows = [
        np.outer(
            _strips(field, int(down), float(y), region.top, region.height),
            _strips(field, int(across), float(x), region.left, region.width),
        ).ravel()
        for (down, across), (x, y) in zip(pairs, place_px, strict=True)
    ]
    return np.stack(rows)


@settings(max_examples=20, deadline=None)
@given(
    seed=st.integers(0, 1000),
    grid=st.sampled_from([1, 2]),
    loss=st.sampled_from([0.0, 0.05]),
    region=st.sampled_from([Region(0, 0, SIZE, SIZE), Region(2, 1, 4, 5)]),
)
def test_the_operator_is_the_matrix_of_integrated_patterns(seed: int, grid: int, loss: float, region: Region) -> None:
    rng, field = np.random.default_rng(seed), Field(SIZE, grid, loss)
    pairs = hadamard_order(SIZE, "tv", 30)
    place_px = rng.integers(-3 * FINE, 3 * FINE, (30, 2)) / FINE
    dense = _dense(pairs, place_px, field, region)
    rows = ShiftedHadamard.single(pairs, place_px, field, region)
    image, values = rng.standard_normal(rows.shape[1]).astype(np.float32), rng.standard_normal(30).astype(np.float32)
    assert rows.shape == dense.shape
    assert rows.image_shapes == ((region.height * grid, region.width * grid),)
    np.testing.assert_allclose(rows.matvec(image), dense @ image, atol=1e-4)
    np.testing.assert_allclose(rows.rmatvec(values), dense.T @ values, atol=1e-4)


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 1000), step=st.sampled_from([0.0, 0.4]), whole=st.booleans())
def test_on_the_finer_grid_matvec_and_rmatvec_are_each_others_transpose(seed: int, step: float, *, whole: bool) -> None:
    """The dot-product test: <A x, y> = <x, A' y>."""
    rng = np.random.default_rng(seed)
    place_px = rng.uniform(-3, 3, (40, 2))
    region = None if whole else Region(1, 2, 5, 4)
    field = Field(SIZE, 2, 0.03)
    rows = ShiftedHadamard.differential(hadamard_order(SIZE, "tv", 40), place_px, place_px + step, field, region)
    image: Singles = rng.standard_normal(rows.shape[1]).astype(np.float32)
    values: Singles = rng.standard_normal(40).astype(np.float32)
    left, right = float(np.vdot(rows.matvec(image), values)), float(np.vdot(image, rows.rmatvec(values)))
    assert left == pytest.approx(right, abs=1e-3)


def test_a_finer_image_that_is_even_within_pattern_pixels_gives_the_same_values() -> None:
    rng = np.random.default_rng(0)
    pairs, place_px = hadamard_order(SIZE, "tv", 30), rng.uniform(-4, 4, (30, 2))
    image = rng.random((SIZE, SIZE)).astype(np.float32)
    coarse, fine = (ShiftedHadamard.single(pairs, place_px, Field(SIZE, grid)) for grid in (1, 2))
    finer = image.repeat(2, axis=0).repeat(2, axis=1)
    np.testing.assert_allclose(fine.matvec(finer.ravel()), coarse.matvec(image.ravel()), atol=1e-4)
