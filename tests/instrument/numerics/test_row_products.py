"""Products of patterns few(u) many(v) against the matrices that they stand for, in whole numbers, which are exact."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.sparse import csr_array

from instrument.numerics import RowProducts
from protocols import Floats

sizes = settings(max_examples=60, deadline=None)


def _some(rng: np.random.Generator, *shape: int) -> Floats:
    """Whole numbers, about a third of them 0."""
    return np.asarray(rng.integers(-4, 5, shape) * (rng.random(shape) < 0.7), np.float64)


def _patterns(few: Floats, many: Floats) -> Floats:
    """Give ``(patterns, length, width)``: weights of the cumulative sum along u are tail sums as weights of the image."""
    tails = np.cumsum(few[:, ::-1], axis=1)[:, ::-1]
    return np.asarray(tails[:, :, None] * many[:, None, :], np.float64)


@sizes
@given(
    seed=st.integers(0, 2**32 - 1),
    patterns=st.integers(1, 9),
    length=st.integers(1, 11),
    width=st.one_of(st.integers(1, 6), st.sampled_from([15, 16, 17, 32, 33])),
    block=st.one_of(st.none(), st.integers(1, 4)),
)
def test_values_and_images_are_those_of_the_dense_patterns(
    seed: int, patterns: int, length: int, width: int, block: int | None
) -> None:
    rng = np.random.default_rng(seed)
    few, many, image, values = (
        _some(rng, *shape) for shape in ((patterns, length), (patterns, width), (length, width), (patterns,))
    )
    dense = _patterns(few, many)
    products = RowProducts.of(csr_array(few), many.astype(np.float32), block=block)

    found = products.forward(image.astype(np.float32))
    back = products.backward(values.astype(np.float32), width)

    np.testing.assert_array_equal(found, np.einsum("kuv,uv->k", dense, image))
    np.testing.assert_array_equal(back, np.einsum("kuv,k->uv", dense, values))


def test_a_pattern_by_hand() -> None:
    """The image's cumulative rows are (1, 2) and (4, 6): 5 (1, 2) - (4, 6) = (1, 4), and (10, 1) of that is 14.

    Backwards 2 (5 - 1) (10, 1) and 2 (-1) (10, 1).
    """
    products = RowProducts.of(csr_array(np.array([[5.0, -1.0]])), np.array([[10.0, 1.0]], np.float32))

    assert products.forward(np.array([[1.0, 2.0], [3.0, 4.0]], np.float32)).tolist() == [14]
    assert products.backward(np.array([2.0], np.float32), 2).tolist() == [[80, 8], [-20, -2]]


@pytest.mark.parametrize("layout", ["F", "strided"])
def test_an_image_may_lie_in_memory_as_it_likes(layout: str) -> None:
    rng = np.random.default_rng(0)
    products = RowProducts.of(csr_array(_some(rng, 5, 7)), _some(rng, 5, 18).astype(np.float32))
    image = _some(rng, 7, 18).astype(np.float32)
    other = np.repeat(image, 2, axis=1)[:, ::2] if layout == "strided" else np.asfortranarray(image)

    assert not other.flags.c_contiguous
    np.testing.assert_array_equal(products.forward(other), products.forward(image))


def test_its_memory_is_that_of_whole_groups_of_16_and_of_the_sparse_weights_twice() -> None:
    """Three rows of 17, kept as 32 singles; four weights with a column each, and starts of 3 + 1 rows, of 5 + 1 transposed."""
    few = np.zeros((3, 5))
    few[0, :2] = few[2, 3:] = 1.0
    products = RowProducts.of(csr_array(few), np.ones((3, 17), np.float32))

    assert products.nbytes == 4 * (3 * 32 + (4 + 4 + 4) + (4 + 4 + 6))
