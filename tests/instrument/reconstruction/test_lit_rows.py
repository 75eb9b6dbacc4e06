"""Rows through an uneven brightness, against the patterns written out."""

import numpy as np
import pytest

from instrument.patterns import walsh_matrix
from instrument.reconstruction import Field, Region, ShiftedHadamard
from instrument.reconstruction.lit_rows import Brightness, Lit
from protocols import Floats

SIZE, GRID = 16, 2
REGION = Region(2, 4, 8, 6)
PLACES = np.stack([np.linspace(-2, 4.5, 40), np.linspace(0, 5.3, 40) ** 1.2], axis=1)
PAIRS = np.stack([np.arange(40) % 5, np.arange(40) // 5], axis=1)


def _falling() -> Floats:
    along = ((np.arange(SIZE) + 0.5) / SIZE - 0.5) ** 2
    return np.asarray(1 - 0.6 * (along[:, None] + along) + 0.2 * along[:, None], np.float64)


def _lit() -> Lit:
    field = Field(SIZE, GRID)
    return Lit(ShiftedHadamard.single(PAIRS, PLACES, field, REGION), Brightness.of(_falling(), PLACES, field, REGION))


def test_terms_add_up_to_the_brightness_at_the_place_of_each_pixel() -> None:
    found = _lit().brightness
    place = np.array([3.25, 1.5])
    near = int(np.argmin(np.hypot(*(PLACES - place).T)))
    seen = np.einsum("j,jyx->yx", found.of_rows[:, near], found.of_pixels)
    y = (REGION.top + (np.arange(16) + 0.5) / GRID + PLACES[near, 1]) / SIZE - 0.5
    x = (REGION.left + (np.arange(12) + 0.5) / GRID + PLACES[near, 0]) / SIZE - 0.5
    np.testing.assert_allclose(seen, 1 - 0.4 * y[:, None] ** 2 - 0.6 * x**2, atol=3e-3)
    assert len(found.of_rows) <= 5


def test_an_even_field_needs_one_term_and_changes_nothing() -> None:
    field = Field(SIZE, GRID)
    even = ShiftedHadamard.single(PAIRS, PLACES, field, REGION)
    lit = Lit(even, Brightness.of(np.ones((SIZE, SIZE)), PLACES, field, REGION))
    image = np.random.default_rng(0).random(even.shape[1]).astype(np.float32)
    assert len(lit.brightness.of_rows) == 1
    np.testing.assert_allclose(lit.matvec(image), even.matvec(image), rtol=1e-4, atol=1e-4)


def test_values_are_those_of_patterns_times_brightness_at_whole_displacements() -> None:
    field, places = Field(SIZE), np.array([[0.0, 0.0], [3.0, 1.0], [2.0, 5.0], [-1.0, 4.0], [1.0, 2.0], [0.0, 3.0]])
    pairs = PAIRS[[1, 7, 12, 33, 20, 38]]
    lit = Lit(ShiftedHadamard.single(pairs, places, field, REGION), Brightness.of(_falling(), places, field, REGION))
    image = np.random.default_rng(1).random(REGION.shape)
    walsh = walsh_matrix(SIZE).astype(np.float64)
    for value, (c_i, c_j), (x, y) in zip(lit.matvec(image.astype(np.float32).ravel()), pairs, places, strict=True):
        pattern = np.outer(walsh[c_i], walsh[c_j]) * _falling()
        top, left = REGION.top + int(y), REGION.left + int(x)
        expected = float(np.sum(pattern[top : top + 8, left : left + 6] * image))
        assert value == pytest.approx(expected, abs=0.02)


def test_the_transpose_is_one() -> None:
    lit, rng = _lit(), np.random.default_rng(2)
    image, values = rng.random(lit.shape[1]).astype(np.float32), rng.standard_normal(40).astype(np.float32)
    assert float(lit.matvec(image) @ values) == pytest.approx(float(image @ lit.rmatvec(values)), rel=1e-4)
    assert lit.image_shapes == ((16, 12),)
