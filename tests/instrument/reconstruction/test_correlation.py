"""Correlation maps against the plain sum over pixels."""

import numpy as np
import pytest

from instrument.plan import Plan
from instrument.reconstruction.correlation import FixedPatterns
from instrument.reconstruction.region import Region
from instrument.schemes import scheme_of
from protocols import Floats
from tests.support.dense import seen_patterns

SIZE = 16
REGION = Region(top=3, left=5, height=8, width=7)


def _places() -> Floats:
    rng = np.random.default_rng(0)
    places = rng.uniform(-20, 20, (30, 4, 2))
    places[0] = [[-16.0, 0.0], [16.0, 3.0], [15.5, -15.5], [-0.25, 0.75]]
    return places


@pytest.mark.parametrize("upsampling", [1, 2])
def test_values_read_from_maps_equal_the_sum_over_pixels(upsampling: int) -> None:
    plan = Plan(frames=4, image_size=SIZE, upsampling=upsampling)
    fixed = FixedPatterns.of(scheme_of(plan), REGION)
    part = np.random.default_rng(1).random(REGION.shape)
    image = REGION.paste(part, SIZE)
    places = _places()
    values, _ = fixed.values(fixed.maps(part.astype(np.float32)), places)
    patterns = fixed.patterns.astype(np.float64)
    for row in range(len(places)):
        seen = seen_patterns(patterns, places[row])
        assert np.allclose(values[row], (seen * image).sum(axis=(1, 2)), atol=1e-4)


def test_slopes_are_the_derivatives_of_the_values() -> None:
    fixed = FixedPatterns.of(scheme_of(Plan(frames=4, image_size=SIZE)), REGION)
    maps = fixed.maps(np.random.default_rng(1).random(REGION.shape).astype(np.float32))
    places = np.floor(_places()[1:]) + 0.4  # well inside a cell, where values are bilinear
    _, slope = fixed.values(maps, places)
    for axis in range(2):
        step = np.zeros(2)
        step[axis] = 0.3
        difference = fixed.values(maps, places + step)[0] - fixed.values(maps, places - step)[0]
        inside = np.abs(places).max(axis=(1, 2)) < SIZE - 1
        assert np.allclose(slope[inside, :, axis], difference[inside] / 0.6, atol=1e-4)
