"""What fixed patterns see of an object that is turned and has grown."""

import numpy as np
import pytest

from instrument.reconstruction import Field, FixedPatterns, Region, ShiftedHadamard, TurnedRows
from instrument.reconstruction.object_shape import ObjectShape
from instrument.tracking import Trajectory
from protocols import Floats, Singles

REGION = Region(3, 2, 9, 8)
PIVOT_PX = np.array([6.3, 7.6])


def _patterns(grid: int) -> FixedPatterns:
    field = Field(16, grid)
    shown = np.random.default_rng(1).integers(0, 2, (3, 16, 16)).astype(np.uint8)
    return FixedPatterns.of(field.acting(shown), field, REGION)


def _image(grid: int) -> Singles:
    return np.random.default_rng(2).random((9 * grid, 8 * grid)).astype(np.float32)


def _places() -> Floats:
    return np.random.default_rng(3).uniform(-3, 3, (20, 3, 2))


def _shape(change: Floats) -> ObjectShape:
    return ObjectShape(PIVOT_PX, change[:, 0], change)


@pytest.mark.parametrize("grid", [1, 2])
def test_an_unchanged_object_is_seen_as_correlation_maps_say(grid: int) -> None:
    patterns, unchanged = _patterns(grid), np.zeros((20, 3, 2))
    values, slopes = _shape(unchanged).values(patterns, _image(grid), _places(), unchanged)
    expected, expected_slopes = patterns.values(patterns.maps(_image(grid)), _places())
    np.testing.assert_allclose(values, expected, atol=2e-4)
    np.testing.assert_allclose(slopes, expected_slopes, atol=2e-3)


@pytest.mark.parametrize("grid", [1, 2])
def test_slopes_are_the_derivatives_of_the_values(grid: int) -> None:
    patterns, image, places = _patterns(grid), _image(grid), _places()
    change = np.random.default_rng(4).uniform(-0.3, 0.3, (20, 3, 2))
    pose = np.concatenate([places, change], axis=-1)

    def seen(pose: Floats) -> tuple[Floats, Floats]:
        return _shape(change).values(patterns, image, pose[..., :2], pose[..., 2:])

    values, slopes = seen(pose)
    for k in range(2):
        moved = pose.copy()
        moved[..., k] += 1e-6
        found = (seen(moved)[0] - values) / 1e-6
        assert np.median(np.abs(found - slopes[..., k])) < 1e-3 * np.abs(slopes[..., k]).max()


def test_the_light_of_an_object_that_grows_goes_with_its_area() -> None:
    """Twice as large, in a field that lets all through: four times as much light."""
    field = Field(16)
    all_on = FixedPatterns.of(np.ones((1, 16, 16), np.float32), field, REGION)
    twice = np.broadcast_to([0.0, np.log(2.0)], (1, 1, 2)).copy()
    image = np.zeros((9, 8), np.float32)
    image[3:6, 3:6] = 1.0
    values, _ = _shape(twice).values(all_on, image, np.zeros((1, 1, 2)), twice)
    assert values[0, 0] == pytest.approx(36.0)


def test_what_lies_outside_the_field_is_not_seen() -> None:
    patterns, unchanged = _patterns(1), np.zeros((1, 3, 2))
    far = np.full((1, 3, 2), [40.0, -3.0])
    values, slopes = _shape(unchanged).values(patterns, _image(1), far, unchanged)
    assert not values.any()
    assert not slopes.any()


@pytest.mark.parametrize("grid", [1, 2])
def test_rows_of_an_unchanged_object_are_the_structured_ones_on_any_grid(grid: int) -> None:
    pairs = np.random.default_rng(5).integers(0, 16, (30, 2))
    places = np.random.default_rng(6).uniform(-3, 3, (30, 2))
    field = Field(16, grid, 0.02)
    turned = TurnedRows(field, pairs, np.hstack([places, np.zeros((30, 2))]), PIVOT_PX, REGION)
    structured = ShiftedHadamard.single(pairs, places, field, REGION)
    image = _image(grid)
    np.testing.assert_allclose(turned.matrix() @ image.ravel(), structured.matvec(image.ravel()), atol=1e-4)
    np.testing.assert_allclose(turned.values(image)[0], structured.matvec(image.ravel()), atol=1e-4)


def test_the_shape_is_read_at_the_times_of_the_patterns() -> None:
    """Frames of 1 s have their middles at 0.5 s, 1.5 s, 2.5 s; H+ and H- are taken together in their middle."""
    path = Trajectory(np.zeros((3, 2)), np.zeros((3, 2)), 1.0, "joint", np.ones(3, np.bool_), pivot_px=PIVOT_PX)
    assert (
        ObjectShape.along(Trajectory(np.zeros((3, 2)), np.zeros((3, 2)), 1.0, "joint", path.valid), np.zeros((1, 3)))
        is None
    )
    turned = Trajectory(
        path.displacement_px,
        path.sigma_px,
        1.0,
        "joint",
        path.valid,
        angle_deg=np.array([0.0, 90.0, 180.0]),
        magnification=np.exp([0.0, 1.0, 2.0]),
        pivot_px=PIVOT_PX,
    )
    time_s = np.array([[1.4, 1.6, 1.0], [2.1, 2.3, 2.0]])
    shape = ObjectShape.along(turned, time_s)
    assert shape is not None
    np.testing.assert_allclose(shape.pair, [[np.pi / 2, 1.0], [0.85 * np.pi, 1.7]])
    np.testing.assert_allclose(shape.fixed, [[[np.pi / 4, 0.5]], [[0.75 * np.pi, 1.5]]])
    still = ObjectShape.along(path, time_s)
    assert still is not None
    assert not still.fixed.any()
