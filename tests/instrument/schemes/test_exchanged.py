"""Schemes whose patterns are wired otherwise than planned: what they say of a value must follow from what was shown there."""

import numpy as np
import pytest

from instrument.plan import Plan
from instrument.schemes import Scheme, exchanges, scheme_of
from protocols import Floats

PLAN = Plan(frames=64, image_size=32)
PLANNED = scheme_of(PLAN)
NAMES = tuple(exchanges(PLANNED))


def light_of(scheme: Scheme, column_px: float, row_px: float) -> Floats:
    """Light of the fixed patterns, ``(k,)``, of a square of 9 px, by the patterns themselves."""
    finer = scheme.fixed_patterns.shape[-1] // PLAN.image_size
    rows = slice(round((row_px - 4) * finer), round((row_px + 5) * finer))
    columns = slice(round((column_px - 4) * finer), round((column_px + 5) * finer))
    return np.asarray(scheme.fixed_patterns[:, rows, columns].mean(axis=(1, 2)), np.float64)


def test_there_are_ten_ways() -> None:
    """Eight of axes and orders but the planned one, and bright and dark of fringes, pair, or both."""
    assert len(NAMES) == 10
    assert exchanges(scheme_of(Plan.model_validate({"frames": 8, "image_size": 32, "scheme": "hadamard"}))) == {}
    assert exchanges(scheme_of(Plan.model_validate({"frames": 8, "image_size": 32, "scheme": "moment"}))) == {}


@pytest.mark.parametrize("name", NAMES)
def test_the_place_of_a_square_is_read_from_the_patterns_as_they_were_shown(name: str) -> None:
    """The patterns of a scheme give a square's light, its reading gives from that light the square's place, to the dithering."""
    scheme = exchanges(PLANNED)[name]
    reading = scheme.position
    assert reading is not None
    assert reading.period_px == 16
    values = np.zeros((1, 6))
    values[0, :4] = light_of(scheme, 9.0, 5.0)
    place = reading.displacement_px(reading.signal(values, np.ones(1)), 1.0)[0] % 16
    np.testing.assert_allclose(place, [9.0, 5.0], atol=0.35)


@pytest.mark.parametrize("name", NAMES)
def test_each_column_has_the_pattern_that_its_order_names(name: str) -> None:
    scheme = exchanges(PLANNED)[name]
    shown = PLANNED.fixed_patterns[list(scheme.order[:4])]
    np.testing.assert_array_equal(scheme.fixed_patterns, 1 - shown if scheme.inverted else shown)
    rows = scheme.image_rows
    assert rows is not None
    assert (rows.positive, rows.negative) == ((5, 4) if scheme.order[4] == 5 else (4, 5))
    assert [column.start for column in scheme.columns] == [column.start for column in PLANNED.columns]
    np.testing.assert_array_equal(scheme.light_weights, [0, 0, 0, 0, 1, 1])


def test_exchanged_axes_are_in_the_order_of_their_names() -> None:
    found = exchanges(PLANNED)
    assert found["the fringes along x and y are exchanged"].order == (2, 3, 0, 1, 4, 5)
    assert found["phases in the place of x come in the reverse order"].order == (1, 0, 2, 3, 4, 5)
    assert found[
        "the fringes along x and y are exchanged, and phases in the place of y come in the reverse order"
    ].order == (
        2,
        3,
        1,
        0,
        4,
        5,
    )
    assert found["H- comes first: exchanged"].order == (0, 1, 2, 3, 5, 4)


def test_the_sequence_stays_as_planned() -> None:
    scheme = exchanges(PLANNED)[NAMES[0]]
    assert scheme.name == "fourier-hadamard"
    np.testing.assert_array_equal(scheme.sequence().play_order, PLANNED.sequence().play_order)
