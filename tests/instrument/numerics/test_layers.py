"""Several images whose light adds, and rows that see nothing."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from instrument.numerics import Layered, Operator, Stacked, Unseen, Weighted
from tests.support.dense import DenseSingles

SEEDS = st.integers(0, 2**32 - 1)


@settings(deadline=None)
@given(seed=SEEDS, rows=st.integers(1, 5))
def test_layers_are_the_matrices_side_by_side(seed: int, rows: int) -> None:
    """Small whole numbers, so that single precision is exact."""
    rng = np.random.default_rng(seed)
    first, second = rng.integers(-9, 10, (rows, 6)).astype(float), rng.integers(-9, 10, (rows, 4)).astype(float)
    layered = Layered((DenseSingles(first, (2, 3)), DenseSingles(second, (4, 1))))
    matrix = np.hstack([first, second])
    image = rng.integers(-9, 10, 10).astype(np.float32)
    values = rng.integers(-9, 10, rows).astype(np.float32)

    assert layered.shape == matrix.shape
    assert layered.image_shapes == ((2, 3), (4, 1))
    np.testing.assert_array_equal(layered.matvec(image), matrix @ image)
    np.testing.assert_array_equal(layered.rmatvec(values), matrix.T @ values)


def test_layers_within_layers_and_weights_and_stacks_keep_their_images() -> None:
    one, two = DenseSingles(np.ones((3, 6)), (2, 3)), DenseSingles(np.ones((3, 4)), (4, 1))
    nested = Layered((one, Layered((two, one))))
    assert nested.image_shapes == ((2, 3), (4, 1), (2, 3))
    assert nested.shape == (3, 16)
    weight = np.array([1, 2, 3], np.float32)
    assert Weighted(nested, weight).image_shapes == nested.image_shapes
    assert Stacked(nested, Unseen(2, nested.image_shapes)).image_shapes == nested.image_shapes
    assert Stacked(nested, Unseen(2, nested.image_shapes)).shape == (5, 16)
    assert nested.matvec(np.ones(16, np.float32)).tolist() == [16, 16, 16]


def test_unseen_rows_are_dark_both_ways() -> None:
    unseen = Unseen(3, ((2, 3), (4, 1)))
    assert unseen.shape == (3, 10)
    assert unseen.matvec(np.ones(10, np.float32)).tolist() == [0, 0, 0]
    assert unseen.rmatvec(np.ones(3, np.float32)).tolist() == [0] * 10


@settings(deadline=None)
@given(seed=SEEDS)
def test_each_is_the_transpose_of_its_transpose(seed: int) -> None:
    """<A x, y> = <x, A' y>."""
    rng = np.random.default_rng(seed)
    one, two = DenseSingles(rng.normal(size=(4, 6)), (2, 3)), DenseSingles(rng.normal(size=(4, 4)), (2, 2))
    operators: tuple[Operator, ...] = (
        Layered((one, two)),
        Unseen(4, ((2, 3),)),
        Layered((one, Unseen(4, ((3, 1),)), two)),
    )
    for operator in operators:
        image = rng.normal(size=operator.shape[1]).astype(np.float32)
        values = rng.normal(size=operator.shape[0]).astype(np.float32)
        left, right = float(np.vdot(operator.matvec(image), values)), float(np.vdot(image, operator.rmatvec(values)))
        assert left == pytest.approx(right, abs=1e-3)
