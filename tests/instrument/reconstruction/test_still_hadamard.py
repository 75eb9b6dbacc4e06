"""Rows of something that stands still: the Walsh transform's entries."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from instrument.patterns import hadamard_order
from instrument.reconstruction import Field, ShiftedHadamard, hadamard_values
from instrument.reconstruction.still_hadamard import StillHadamard

SIZE = 8


@given(seed=st.integers(0, 1000), count=st.integers(1, 64), loss=st.sampled_from([0.0, 0.04]))
def test_rows_are_those_of_an_object_that_never_moves(seed: int, count: int, loss: float) -> None:
    rng, field = np.random.default_rng(seed), Field(SIZE, 1, loss)
    pairs = rng.permutation(hadamard_order(SIZE, "tv"))[:count]
    still = StillHadamard.of(pairs, field)
    moving = ShiftedHadamard.single(pairs, np.zeros((count, 2)), field)
    image, values = rng.standard_normal(64).astype(np.float32), rng.standard_normal(count).astype(np.float32)
    assert still.shape == moving.shape
    assert still.image_shapes == moving.image_shapes
    np.testing.assert_allclose(still.matvec(image), moving.matvec(image), atol=1e-4)
    np.testing.assert_allclose(still.matvec(image), hadamard_values(field, image.reshape(8, 8), pairs), atol=1e-4)
    np.testing.assert_allclose(still.rmatvec(values), moving.rmatvec(values), atol=1e-4)
    assert float(np.vdot(still.matvec(image), values)) == pytest.approx(
        float(np.vdot(image, still.rmatvec(values))), abs=1e-3
    )


def test_patterns_shown_twice_add_up_in_the_transpose() -> None:
    """w_1 down of 2 pixels is + over -; twice with values 1 and 2."""
    still = StillHadamard.of(np.array([[1, 0], [1, 0]]), Field(2))
    assert still.rmatvec(np.array([1, 2], np.float32)).tolist() == [3, 3, -3, -3]
    assert still.matvec(np.array([1, 2, 3, 5], np.float32)).tolist() == [-5, -5]


def test_only_rows_that_are_needed_are_kept_and_always_on_the_patterns_grid() -> None:
    still = StillHadamard.of(np.array([[1, 2], [0, 0]]), Field(SIZE, 2))
    assert still.walsh.shape == (3, 8)
    assert still.shape == (2, 64)
