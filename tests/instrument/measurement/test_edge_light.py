"""Light that Hadamard patterns lose at the edges of their lit pixels, counted pixel by pixel."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from instrument.measurement import bordering_share
from instrument.measurement.edge_light import with_edge_light
from instrument.patterns import hadamard_signs
from instrument.plan import Plan
from instrument.schemes import image_rows_of, scheme_of
from protocols import Floats
from tests.support.plans import plan_of

SIZE = 16


def _sides(lit: Floats) -> Floats:
    """Sides of each lit pixel that border a dark one inside the field."""
    around = np.pad(lit, 1, mode="edge")
    neighbours = (around[:-2, 1:-1], around[2:, 1:-1], around[1:-1, :-2], around[1:-1, 2:])
    return np.asarray(lit * sum(1 - side for side in neighbours), np.float64)


def test_the_share_by_hand() -> None:
    """All on: no border. One border across 16 pixels: a row on either side. A checkerboard of 2 x 2 pixels: 2 sides each."""
    assert bordering_share(np.array([[0, 0], [1, 0], [2, 3]]), 16).tolist() == [0.0, 2 / 16, 10 / 16]
    assert bordering_share(np.array([[1, 1]]), 2).tolist() == [2.0]


@given(down=st.integers(0, SIZE - 1), across=st.integers(0, SIZE - 1))
def test_the_share_is_that_of_a_pattern_and_its_complement_counted(down: int, across: int) -> None:
    signs = hadamard_signs(SIZE, np.array([[down, across]])).astype(np.float64)[0]
    counted = _sides((1 + signs) / 2).sum() + _sides((1 - signs) / 2).sum()
    assert bordering_share(np.array([[down, across]]), SIZE)[0] == pytest.approx(counted / SIZE**2)


def test_a_pair_that_lost_light_adds_to_the_all_on_light_again() -> None:
    """A uniform object of 256 px: each pair is made with an edge loss of 0.03, and given back 256, its difference kept."""
    scheme = scheme_of(Plan(frames=40, image_size=SIZE))
    rows = image_rows_of(scheme)
    signs = hadamard_signs(SIZE, rows.pairs[:40]).astype(np.float64)
    values = np.full((40, 6), 7.0)
    for column, sign in ((rows.positive, 1), (rows.negative, -1)):
        lit = (1 + sign * signs) / 2
        values[:, column] = [float((plane - 0.03 * _sides(plane)).sum()) for plane in lit]
    before = values.copy()

    found = with_edge_light(values, scheme, SIZE, 0.03)

    pair = [rows.positive, rows.negative]
    assert np.ptp(values[:, pair].sum(axis=1)) > 5
    np.testing.assert_allclose(found[:, pair].sum(axis=1), 256.0)
    np.testing.assert_allclose(np.diff(found[:, pair]), np.diff(values[:, pair]), atol=1e-9)
    assert (found[:, :4] == 7.0).all()
    np.testing.assert_array_equal(values, before)


def test_patterns_that_begin_anew_lose_what_they_lost_before() -> None:
    """Sixteen patterns of 4 x 4 pixels, shown twice and a half."""
    scheme = scheme_of(Plan(frames=40, image_size=8))
    count = len(image_rows_of(scheme).pairs)
    values = np.ones((count + 5, 6))
    found = with_edge_light(values, scheme, 8, 0.05)
    np.testing.assert_array_equal(found[count:], found[:5])


def test_nothing_lost_or_no_pair_is_nothing_to_give_back() -> None:
    values = np.ones((10, 6))
    assert with_edge_light(values, scheme_of(Plan(frames=10, image_size=SIZE)), SIZE, 0.0) is values
    assert with_edge_light(values, scheme_of(plan_of("fourier-3step", 10, SIZE)), SIZE, 0.1) is values
