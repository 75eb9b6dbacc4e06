"""Correlation maps against the plain sum over pixels."""

import numpy as np
import pytest

from instrument.plan import Plan
from instrument.reconstruction import Field, FixedPatterns, Region
from instrument.schemes import FourierHadamardSettings, scheme_of
from protocols import Bytes, Floats
from tests.support.dense import seen_patterns

SIZE = 16
REGION = Region(top=3, left=5, height=8, width=7)


def _patterns(upsampling: int = 1) -> Bytes:
    settings = FourierHadamardSettings(upsampling=upsampling)
    return scheme_of(Plan(frames=4, image_size=SIZE, scheme=settings)).fixed_patterns


def _places() -> Floats:
    rng = np.random.default_rng(0)
    places = rng.uniform(-20, 20, (30, 4, 2))
    places[0] = [[-16.0, 0.0], [16.0, 3.0], [15.5, -15.5], [-0.25, 0.75]]
    return places


@pytest.mark.parametrize("upsampling", [1, 2])
def test_values_read_from_maps_equal_the_sum_over_pixels(upsampling: int) -> None:
    fixed = FixedPatterns.of(Field(SIZE).acting(_patterns(upsampling)), Field(SIZE), REGION)
    part = np.random.default_rng(1).random(REGION.shape)
    image = REGION.paste(part, SIZE)
    places = _places()
    values, _ = fixed.values(fixed.maps(part.astype(np.float32)), places)
    patterns = fixed.patterns.astype(np.float64)
    for row in range(len(places)):
        seen = seen_patterns(patterns, places[row])
        assert np.allclose(values[row], (seen * image).sum(axis=(1, 2)), atol=1e-4)


@pytest.mark.parametrize("wide", [True, False])
def test_sampling_and_maps_have_transposes(wide: bool) -> None:  # noqa: FBT001  (a parameter of the test)
    """<C x, y> = <x, C' y>, for all displacements and for those that keep the object inside the field."""
    rng = np.random.default_rng(2)
    places = _places() if wide else rng.uniform((-5, -3), (4, 5), (30, 4, 2))
    fixed = FixedPatterns.of(Field(SIZE).acting(_patterns()), Field(SIZE), REGION, places)
    sampling = fixed.sampling(places)
    part, values = rng.random(REGION.shape, np.float32), rng.random(120, np.float32)

    seen = sampling @ fixed.maps(part).ravel()
    image = fixed.image((sampling.T @ values).astype(np.float32).reshape(4, fixed.width, fixed.width))

    assert fixed.width == (32 if wide else 18)
    assert np.allclose(seen, fixed.values(fixed.maps(part), places)[0].ravel(), atol=1e-4)
    assert np.vdot(seen, values) == pytest.approx(np.vdot(part, image), rel=1e-4)


def test_small_maps_give_the_same_values_as_large_ones() -> None:
    """The region begins 5 and 3 px from the field's borders and ends 4 and 5 px from the others."""
    places = np.random.default_rng(3).uniform((-5.9, -3.9), (4.9, 5.9), (50, 4, 2))
    patterns = _patterns()
    small, large = (
        FixedPatterns.of(Field(SIZE).acting(patterns), Field(SIZE), REGION, places),
        FixedPatterns.of(Field(SIZE).acting(patterns), Field(SIZE), REGION),
    )
    part = np.random.default_rng(1).random(REGION.shape, np.float32)

    for ours, others in zip(
        small.values(small.maps(part), places), large.values(large.maps(part), places), strict=True
    ):
        assert np.allclose(ours, others, atol=1e-4)


def test_slopes_are_the_derivatives_of_the_values() -> None:
    fixed = FixedPatterns.of(Field(SIZE).acting(_patterns()), Field(SIZE), REGION)
    maps = fixed.maps(np.random.default_rng(1).random(REGION.shape).astype(np.float32))
    places = np.floor(_places()[1:]) + 0.4  # well inside a cell, where values are bilinear
    _, slope = fixed.values(maps, places)
    for axis in range(2):
        step = np.zeros(2)
        step[axis] = 0.3
        difference = fixed.values(maps, places + step)[0] - fixed.values(maps, places - step)[0]
        inside = np.abs(places).max(axis=(1, 2)) < SIZE - 1
        assert np.allclose(slope[inside, :, axis], difference[inside] / 0.6, atol=1e-4)
