"""Ramps whose value over the total light is where the light is."""

from typing import Literal

import numpy as np
import pytest

from instrument.patterns import floyd_steinberg, moment_pattern
from instrument.patterns.moment import ramp


def test_a_ramp_goes_from_border_to_border() -> None:
    """Middles of four pixels: 1/8, 3/8, 5/8, 7/8 of the field."""
    np.testing.assert_array_equal(ramp(4, "x"), [[0.125, 0.375, 0.625, 0.875]] * 4)
    np.testing.assert_array_equal(ramp(4, "y"), ramp(4, "x").T)
    np.testing.assert_array_equal(ramp(2, "x", 2), ramp(4, "x"))


@pytest.mark.parametrize(("row", "column"), [(0, 0), (3, 5), (7, 7)])
def test_a_lit_pixel_is_seen_at_its_middle(row: int, column: int) -> None:
    image = np.zeros((8, 8))
    image[row, column] = 0.7
    assert 8 * (ramp(8, "x") * image).sum() / image.sum() == pytest.approx(column + 0.5)
    assert 8 * (ramp(8, "y") * image).sum() / image.sum() == pytest.approx(row + 0.5)


@pytest.mark.parametrize("axis", ["x", "y"])
def test_the_binary_ramp_is_the_dithered_one_made_once_and_kept(axis: Literal["x", "y"]) -> None:
    pattern = moment_pattern(16, axis, 2)
    np.testing.assert_array_equal(pattern, floyd_steinberg(ramp(16, axis, 2)))
    assert moment_pattern(16, axis, 2) is pattern
    with pytest.raises(ValueError, match="read-only"):
        pattern[0, 0] = 1


@pytest.mark.parametrize(("row", "column", "sixteenths"), [(0, 2, 7), (1, 0, 3), (1, 1, 5), (1, 2, 1)])
@pytest.mark.parametrize(("part", "lit"), [(0.75, 1), (1.25, 0)])
def test_error_diffusion_shares_an_error_by_sixteenths(
    row: int, column: int, sixteenths: int, part: float, lit: int
) -> None:
    """One lit sample of 1.6 leaves an error of 0.6. All neighbours but one take exactly their share and hand on nothing.

    That one lacks 3/4 of its share to 1/2, or 5/4 of it, so that the share itself makes the difference.
    """
    grey = np.array([[0, 1.6, -0.6 * 7 / 16], [-0.6 * 3 / 16, -0.6 * 5 / 16, -0.6 / 16]])
    grey[row, column] = 0.5 - part * 0.6 * sixteenths / 16
    assert floyd_steinberg(grey)[row, column] == lit
