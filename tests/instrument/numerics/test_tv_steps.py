"""The half steps of total variation against the matrix K, built here difference by difference."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from instrument.numerics.tv_steps import CORNERS, K_SQUARED, dual_step, gradient_norms, primal_step
from protocols import Floats, Singles

SHAPES = st.tuples(st.integers(1, 6), st.integers(1, 7))
CORNER_SIDES = ((1, 1), (1, -1), (-1, 1), (-1, -1))
"""Neighbour in y and neighbour in x of each corner: below right, below left, above right, above left."""

_UNBOUNDED = 1e9
quick = settings(max_examples=40, deadline=None)


def _k(height: int, width: int) -> Floats:
    """Give K: rows along the dual variable's axes (component, corner, y, x), columns along the image's pixels."""
    matrix = np.zeros((2, CORNERS, height, width, height, width))
    for corner, (down, right) in enumerate(CORNER_SIDES):
        for y in range(height):
            for x in range(width):
                if 0 <= y + down < height:
                    matrix[0, corner, y, x, y + down, x] += down / 2
                    matrix[0, corner, y, x, y, x] -= down / 2
                if 0 <= x + right < width:
                    matrix[1, corner, y, x, y, x + right] += right / 2
                    matrix[1, corner, y, x, y, x] -= right / 2
    return matrix.reshape(2 * CORNERS * height * width, height * width)


def _whole(rng: np.random.Generator, *shape: int) -> Singles:
    return rng.integers(-8, 9, shape).astype(np.float32)


@quick
@given(shape=SHAPES, seed=st.integers(0, 2**32 - 1))
def test_the_primal_proposal_is_that_of_the_dense_transpose(shape: tuple[int, int], seed: int) -> None:
    """Steps of 1/4 and 1/2 keep all numbers exact; what would be below 0 is 0. Dual variables have 0 beyond the border."""
    rng, k = np.random.default_rng(seed), _k(*shape)
    image, gradient, dual = _whole(rng, *shape), _whole(rng, *shape), _whole(rng, 2, CORNERS, *shape)
    dual *= k.any(axis=1).reshape(dual.shape)
    expected = np.maximum(0, image - gradient / 4 - (k.T @ dual.ravel()).reshape(shape) / 2)

    proposal = gradient.copy()
    primal_step(image, dual, proposal, 0.25, 0.5)

    np.testing.assert_array_equal(proposal, expected)


@quick
@given(shape=SHAPES, seed=st.integers(0, 2**32 - 1), rho=st.sampled_from([1.0, 1.5, 0.5]))
def test_the_dual_step_is_that_of_the_dense_matrix(shape: tuple[int, int], seed: int, rho: float) -> None:
    """No bound is met: the dual variable moves by rho sigma K (2 proposal - image), the image by rho (proposal - image)."""
    rng = np.random.default_rng(seed)
    image, proposal, dual = _whole(rng, *shape), _whole(rng, *shape), _whole(rng, 2, CORNERS, *shape)
    moved = dual + (rho / 4 * _k(*shape) @ (2 * proposal - image).ravel()).reshape(dual.shape)
    expected = image + rho * (proposal - image)

    dual_step(image, dual, proposal, np.full((CORNERS, *shape), _UNBOUNDED, np.float32), 0.25, rho)

    np.testing.assert_array_equal(dual, moved)
    np.testing.assert_array_equal(image, expected)


@quick
@given(shape=SHAPES, seed=st.integers(0, 2**32 - 1))
def test_each_corner_s_vector_is_shortened_to_its_own_bound_and_keeps_its_direction(
    shape: tuple[int, int], seed: int
) -> None:
    rng = np.random.default_rng(seed)
    dual = rng.normal(size=(2, CORNERS, *shape)).astype(np.float32)
    bound = rng.uniform(0.1, 2, (CORNERS, *shape)).astype(np.float32)
    length = np.hypot(dual[0], dual[1])
    expected = dual * np.minimum(1, bound / length)
    flat = np.full(shape, 3, np.float32)

    dual_step(flat, dual, flat.copy(), bound, 0.25, 1.0)

    np.testing.assert_allclose(dual, expected, rtol=1e-5)


def test_a_vector_of_3_and_4_under_a_bound_of_1_becomes_three_and_four_fifths() -> None:
    """Over-relaxed by 3/2 it goes half as far again: 3 - 3/2 (3 - 0.6) = -0.6 and 4 - 3/2 (4 - 0.8) = -0.8."""
    dual = np.zeros((2, CORNERS, 1, 1), np.float32)
    dual[:, 2, 0, 0] = 3, 4
    dual_step(
        np.zeros((1, 1), np.float32), dual, np.zeros((1, 1), np.float32), np.ones((CORNERS, 1, 1), np.float32), 1, 1.5
    )
    np.testing.assert_allclose(dual[:, 2, 0, 0], [-0.6, -0.8], rtol=1e-6)
    assert not dual[:, [0, 1, 3]].any()


@pytest.mark.parametrize("shape", [(1, 9), (5, 5), (12, 8)])
def test_k_transposed_times_k_is_the_laplacian_of_the_grid(shape: tuple[int, int]) -> None:
    """One step to and one fro. Cosine waves are its eigenvectors, with 4 sin^2(pi i / 2h) + 4 sin^2(pi j / 2w), below 8."""
    height, width = shape
    rows, columns = np.indices(shape)
    for i, j in ((0, 0), (height // 2, 1), (height - 1, width - 1)):
        wave = np.cos(np.pi * i * (rows + 0.5) / height) * np.cos(np.pi * j * (columns + 0.5) / width)
        eigenvalue = 4 * np.sin(np.pi * i / 2 / height) ** 2 + 4 * np.sin(np.pi * j / 2 / width) ** 2
        dual = np.zeros((2, CORNERS, *shape), np.float32)
        seen = wave.astype(np.float32)
        dual_step(seen.copy(), dual, seen, np.full((CORNERS, *shape), _UNBOUNDED, np.float32), 1.0, 1.0)
        ground = np.full(shape, 10, np.float32)
        back = np.zeros(shape, np.float32)
        primal_step(ground, dual, back, 0.0, 1.0)

        np.testing.assert_allclose(10 - back, eigenvalue * wave, atol=1e-5)
        assert eigenvalue < K_SQUARED


@quick
@given(shape=SHAPES, seed=st.integers(0, 2**32 - 1))
def test_gradient_norms_are_twice_the_lengths_of_k_times_the_image(shape: tuple[int, int], seed: int) -> None:
    image = _whole(np.random.default_rng(seed), *shape)
    along_y, along_x = (_k(*shape) @ image.ravel()).reshape(2, CORNERS, *shape)
    np.testing.assert_allclose(gradient_norms(image), 2 * np.hypot(along_y, along_x), rtol=1e-6)


def test_gradient_norms_of_four_pixels_by_hand() -> None:
    """0 beside 3 above 4 beside 0: from the pixel 0 on top 4 goes down and 3 to the right, and nothing up or left."""
    norms = gradient_norms(np.array([[0, 3], [4, 0]], np.float32))
    assert norms[:, 0, 0].tolist() == [5, 4, 3, 0]
    assert norms[:, 1, 1].tolist() == [0, 4, 3, 5]
    assert norms[:, 0, 1].tolist() == [3, pytest.approx(18**0.5), 0, 3]
