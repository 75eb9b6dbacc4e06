"""The structured operator against the matrix written out."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from instrument.numerics import Weighted, largest_eigenvalue
from instrument.patterns import hadamard_order
from instrument.reconstruction import Field, Region, ShiftedHadamard
from instrument.reconstruction.walsh_rows import walsh_changes, walsh_rows
from protocols import Floats, InputError
from tests.support.dense import dense_differential

SIZE = 16


def _paths(rows: int, seed: int, travel_px: float) -> Floats:
    return np.random.default_rng(seed).uniform(-travel_px, travel_px, (rows, 2))


def _singles(count: int, seed: int) -> np.ndarray[tuple[int], np.dtype[np.float32]]:
    return np.random.default_rng(seed).standard_normal(count).astype(np.float32)


def test_a_row_of_the_all_one_pattern_moved_half_a_pixel_ends_with_half_a_pixel() -> None:
    """H = 1, object moved by +0.5 px in x: the last column is half out of the field, the others see 1."""
    rows = ShiftedHadamard.single(np.array([[0, 0]]), np.array([[0.5, 0.0]]), Field(8))
    row = rows.rmatvec(np.ones(1, np.float32)).reshape(8, 8)
    assert np.array_equal(row[0], [1, 1, 1, 1, 1, 1, 1, 0.5])


def test_a_walsh_row_with_one_change_is_three_differences_of_the_cumulative_sum() -> None:
    """w_1 of 4 pixels is + + - -: 2 C[1] - C[3] for an object at 0.

    After a quarter of a pixel the change at 2 falls three quarters into the second pixel, and the last quarter pixel has left.
    """
    assert walsh_changes(Field(4), np.array([1]), np.array([0.0]), 0, 4).toarray().tolist() == [[0, 2, 0, -1]]
    assert walsh_changes(Field(4), np.array([1]), np.array([0.25]), 0, 4).toarray().tolist() == [
        [0.5, 1.5, -0.25, -0.75]
    ]
    assert walsh_rows(Field(4), np.array([1]), np.array([0.25]), 0, 4).tolist() == [[1, 0.5, -1, -0.75]]


def test_an_object_moved_out_of_the_field_sees_nothing() -> None:
    places = np.array([[8.0, 0.0], [0.0, -8.0], [1e6, 0.0], [0.0, -1e6]])
    rows = ShiftedHadamard.single(np.zeros((4, 2), np.int64), places, Field(8))
    assert not rows.matvec(np.ones(64, np.float32)).any()


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 1000), travel=st.floats(0, 20), step=st.sampled_from([0.0, 0.5, 3.0]))
def test_rows_equal_the_patterns_moved_back_one_by_one(seed: int, travel: float, step: float) -> None:
    pairs = hadamard_order(SIZE, "tv", 40)
    positive = _paths(40, seed, travel)
    negative = positive + step
    rows = ShiftedHadamard.differential(pairs, positive, negative, Field(SIZE))
    dense = dense_differential(pairs, positive, negative, SIZE)
    image = _singles(SIZE * SIZE, seed)
    assert rows.shape == dense.shape == (40, 256)
    assert np.allclose(rows.matvec(image), dense.matvec(image.astype(np.float64)), atol=2e-4)
    values = _singles(40, seed + 1)
    assert np.allclose(rows.rmatvec(values), dense.rmatvec(values.astype(np.float64)), atol=1e-4)


@pytest.mark.parametrize("step", [0.0, 0.7])
@pytest.mark.parametrize("region", [None, Region(3, 1, 9, 12)])
def test_matvec_and_rmatvec_are_each_others_transpose(region: Region | None, step: float) -> None:
    """The dot-product test: <A x, y> = <x, A' y>."""
    places = _paths(60, 3, 6.0)
    rows = ShiftedHadamard.differential(
        hadamard_order(SIZE, "hyperbolic", 60), places, places + step, Field(SIZE), region
    )
    for operator in (rows, Weighted(rows, _singles(60, 9))):
        image, values = _singles(operator.shape[1], 4), _singles(60, 5)
        left, right = np.vdot(operator.matvec(image), values), np.vdot(image, operator.rmatvec(values))
        assert left == pytest.approx(right, rel=1e-4)


def test_in_a_region_rows_are_cut_to_it() -> None:
    region = Region(4, 2, 7, 10)
    pairs, places = hadamard_order(SIZE, "tv", 25), _paths(25, 8, 3.0)
    part = _singles(70, 1)
    cut = ShiftedHadamard.single(pairs, places, Field(SIZE), region).matvec(part)
    whole = region.paste(part.reshape(7, 10).astype(np.float64), SIZE).astype(np.float32)
    assert np.allclose(cut, ShiftedHadamard.single(pairs, places, Field(SIZE)).matvec(whole.ravel()), atol=1e-5)


def test_without_motion_the_largest_eigenvalue_is_the_number_of_pixels() -> None:
    """Hadamard rows are orthogonal and of squared length 256."""
    rows = ShiftedHadamard.single(hadamard_order(SIZE, "tv", 100), np.zeros((100, 2)), Field(SIZE))
    assert largest_eigenvalue(rows) == pytest.approx(256, rel=1e-4)


def test_the_operator_of_a_whole_run_takes_less_than_four_megabytes() -> None:
    pairs, places = hadamard_order(128, "tv", 1666), _paths(1666, 0, 40.0)
    rows = ShiftedHadamard.single(pairs, places, Field(128))
    assert rows.shape == (1666, 16384)
    assert (
        1666 * 128 * 4 < rows.nbytes < 4e6
    )  # one factor of float32, and the sign changes of the other: the matrix has 218 MB


def test_with_motion_within_the_frame_it_does_too() -> None:
    """Two patterns a row, H at two places, of an object that stays inside the field."""
    pairs, places = hadamard_order(128, "tv", 1666), _paths(1666, 0, 20.0)
    assert ShiftedHadamard.differential(pairs, places, places + 1.0, Field(128), Region(20, 20, 88, 88)).nbytes < 4e6


def test_single_precision_stays_a_million_times_below_the_noise_of_the_paper() -> None:
    """Sigma 0.1 on each of 8,192 lit pixels is 9.05 a value."""
    rng = np.random.default_rng(2)
    pairs, places = hadamard_order(128, "tv", 300), _paths(300, 2, 30.0)
    image = rng.random(128 * 128)
    rows = ShiftedHadamard.single(pairs, places, Field(128))
    down, across = (
        walsh_rows(Field(128), pairs[:, axis], places[:, 1 - axis], 0, 128).astype(np.float64) for axis in range(2)
    )
    exact = np.vecdot(down @ image.reshape(128, 128), across)
    assert np.abs(rows.matvec(image.astype(np.float32)) - exact).max() < 9.05e-3
    assert np.abs(exact).max() > 100


def test_the_region_is_what_the_object_can_occupy_at_frame_0() -> None:
    """X goes to +5.2: the object ends 5.2 px before the right border. y goes to -3.7: it begins 3.7 px below the top."""
    region = Region.inside(np.array([[0.0, 0.0], [5.2, -3.7]]), 32)
    assert region == Region(top=3, left=0, height=29, width=27)


def test_a_way_longer_than_the_field_has_no_region() -> None:
    with pytest.raises(InputError, match='region "wide"'):
        Region.inside(np.array([[0.0, 0.0], [30.0, 0.0]]), 32)


def test_patterns_with_many_changes_along_both_axes_are_matrix_products_and_give_the_same(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    """All 4,096 patterns of 64 x 64: of these 2,809 have 11 changes or more, 0.17 times 64, along both axes."""
    size, rng = 64, np.random.default_rng(0)
    pairs = hadamard_order(size, "tv", size * size)
    path = np.linspace(0, 9.3, len(pairs))[:, None] * np.array([1.0, -0.5])
    region = Region.inside(path, size)
    both = ShiftedHadamard.single(pairs, path, Field(size), region)
    image = rng.random(region.height * region.width).astype(np.float32)
    values = rng.standard_normal(len(pairs)).astype(np.float32)
    assert both.dense_patterns == 2809
    few = ShiftedHadamard.single(pairs[-1000:], path[-1000:], Field(size), region)
    assert few.dense_patterns == 0  # too few to be worth it
    found = both.matvec(image), both.rmatvec(values)

    monkeypatch.setattr("instrument.reconstruction.shifted_hadamard._LARGE", 0)  # on several cores
    for one, other in zip(found, (both.matvec(image), both.rmatvec(values)), strict=True):
        np.testing.assert_array_equal(one, other)

    monkeypatch.setattr("instrument.reconstruction.shifted_hadamard._OFTEN", 9.0)
    sparse = ShiftedHadamard.single(pairs, path, Field(size), region)
    assert np.count_nonzero(pairs.min(axis=1) >= 11) == 2809
    assert both.nbytes < sparse.nbytes
    np.testing.assert_allclose(found[0], sparse.matvec(image), atol=1e-5 * float(np.abs(found[0]).max()))
    np.testing.assert_allclose(found[1], sparse.rmatvec(values), atol=1e-5 * float(np.abs(found[1]).max()))
