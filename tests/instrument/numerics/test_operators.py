"""Weighted and stacked rows against the matrices that they stand for."""

import itertools

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from instrument.numerics import Stacked, Weighted, largest_eigenvalue
from tests.support.dense import DenseSingles

SEEDS = st.integers(0, 2**32 - 1)


@settings(deadline=None)
@given(seed=SEEDS, above=st.integers(1, 5), below=st.integers(1, 5))
def test_stacked_and_weighted_rows_are_those_of_the_matrix_and_its_transpose(seed: int, above: int, below: int) -> None:
    """Small whole numbers, so that single precision is exact."""
    rng = np.random.default_rng(seed)
    first, second = rng.integers(-9, 10, (above, 6)).astype(float), rng.integers(-9, 10, (below, 6)).astype(float)
    weight = rng.integers(-9, 10, above).astype(np.float32)
    rows = Stacked(Weighted(DenseSingles(first, (2, 3)), weight), DenseSingles(second, (2, 3)))
    matrix = np.vstack([np.diag(weight) @ first, second])
    image = rng.integers(-9, 10, 6).astype(np.float32)
    values = rng.integers(-9, 10, above + below).astype(np.float32)

    assert rows.shape == matrix.shape
    assert rows.image_shapes == rows.above.image_shapes == ((2, 3),)
    np.testing.assert_array_equal(rows.matvec(image), matrix @ image)
    np.testing.assert_array_equal(rows.rmatvec(values), matrix.T @ values)


def test_the_largest_eigenvalue_is_the_square_of_the_largest_singular_value() -> None:
    """Singular values 3, 2 and 1 behind two rotations: after 20 steps the second has (4 / 9)^20 of the first."""
    rng = np.random.default_rng(3)
    left, right = (np.linalg.qr(rng.normal(size=(3, 3)))[0] for _ in range(2))
    rows = DenseSingles(np.asarray(left @ np.diag([3.0, 2.0, 1.0]) @ right, np.float64), (1, 3))

    assert largest_eigenvalue(rows) == pytest.approx(9.0, rel=1e-5)


@settings(deadline=None)
@given(seed=SEEDS)
def test_the_power_method_comes_from_below_and_each_step_comes_nearer(seed: int) -> None:
    matrix = np.random.default_rng(seed).normal(size=(7, 5))
    exact = float(np.linalg.eigvalsh(matrix.T @ matrix)[-1])
    found = [largest_eigenvalue(DenseSingles(matrix, (1, 5)), steps) for steps in (1, 2, 5, 20)]

    assert all(late >= early * (1 - 1e-5) for early, late in itertools.pairwise(found))
    assert 0 < found[-1] <= exact * (1 + 1e-5)


def test_rows_that_see_all_images_alike_need_one_step_and_the_dark_has_eigenvalue_0() -> None:
    assert largest_eigenvalue(DenseSingles(4 * np.eye(6), (2, 3)), 1) == pytest.approx(16.0, rel=1e-6)
    assert largest_eigenvalue(DenseSingles(np.zeros((4, 6)), (2, 3))) == 0.0
