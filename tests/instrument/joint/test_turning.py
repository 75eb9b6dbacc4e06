"""Path, angle and image of an object that turns, found together."""

from functools import cache

import numpy as np
import pytest

from instrument.analysis import Analysis, analyse
from instrument.joint import refine_turn
from instrument.measurement import first_light
from instrument.reconstruction import Field, Region, ShiftedHadamard, TurnedRows
from instrument.tracking import Trajectory
from protocols import Floats, InputError, Integers
from tests.instrument.schemes.test_moment_rotation import turning

FIELD = Field(16)


def patterns() -> tuple[Integers, Floats]:
    rng = np.random.default_rng(3)
    return rng.integers(0, 16, (40, 2)), rng.uniform(-3, 3, (40, 2))


def test_rows_of_an_object_that_has_not_turned_are_the_structured_ones() -> None:
    pairs, places_px = patterns()
    region = Region(3, 2, 9, 10)
    turned = TurnedRows(FIELD, pairs, np.column_stack([places_px, np.zeros((40, 2))]), np.array([7.3, 6.1]), region)
    structured = ShiftedHadamard.single(pairs, places_px, FIELD, region)
    image = np.random.default_rng(1).random((9, 10)).astype(np.float32)

    np.testing.assert_allclose(turned.matrix() @ image.ravel(), structured.matvec(image.ravel()), atol=1e-4)
    np.testing.assert_allclose(turned.values(image)[0], structured.matvec(image.ravel()), atol=1e-4)


def test_rows_of_a_quarter_turn_are_those_of_the_turned_image() -> None:
    """Clockwise about the middle: what was at row r, column c is at row c, column 15 - r."""
    pairs, _ = patterns()
    image = np.random.default_rng(1).random((16, 16)).astype(np.float32)
    middle_px = np.array([7.5, 7.5])
    quarter = np.column_stack([np.zeros((40, 2)), np.full(40, np.pi / 2), np.zeros(40)])
    still = TurnedRows(FIELD, pairs, np.zeros((40, 4)), middle_px, Region.whole(16))
    turned = TurnedRows(FIELD, pairs, quarter, middle_px, Region.whole(16))

    np.testing.assert_allclose(turned.values(image)[0], still.values(np.rot90(image, -1))[0], atol=1e-3)


def test_rows_of_an_object_twice_as_large_have_four_times_the_light() -> None:
    """Twice as large about the middle, a square of 4 px is one of 8 px."""
    pairs, _ = patterns()
    middle_px = np.array([7.5, 7.5])
    small, large = np.zeros((2, 16, 16), np.float32)
    small[6:10, 6:10], large[4:12, 4:12] = 1.0, 1.0
    all_on = np.zeros((1, 2), np.int64)
    twice = np.array([[0.0, 0.0, 0.0, np.log(2.0)]])

    grown = TurnedRows(FIELD, all_on, twice, middle_px, Region.whole(16))
    assert grown.values(small)[0][0] == pytest.approx(64.0)
    coarse = pairs[(pairs < 4).all(axis=1)]  # what a pixel twice as wide covers is taken at its middle
    grown = TurnedRows(FIELD, coarse, twice.repeat(len(coarse), 0), middle_px, Region.whole(16))
    expected = TurnedRows(FIELD, coarse, np.zeros((len(coarse), 4)), middle_px, Region.whole(16))
    np.testing.assert_allclose(grown.values(small)[0], expected.values(large)[0], atol=1e-3)


def test_slopes_are_the_derivatives_of_the_values() -> None:
    pairs, places_px = patterns()
    rng = np.random.default_rng(2)
    pose = np.column_stack([places_px, rng.uniform(-1, 1, 40), rng.uniform(-0.2, 0.2, 40)])
    image = np.random.default_rng(1).random((9, 10)).astype(np.float32)

    def rows(pose: Floats) -> TurnedRows:
        return TurnedRows(FIELD, pairs, pose, np.array([7.3, 6.1]), Region(3, 2, 9, 10))

    values, slopes = rows(pose).values(image)
    np.testing.assert_allclose(rows(pose).matrix() @ image.ravel(), values, atol=1e-4)
    for k, step in ((0, 1e-5), (1, 1e-5), (2, 1e-6), (3, 1e-6)):
        moved = pose.copy()
        moved[:, k] += step
        found = (rows(moved).values(image)[0] - values) / step
        assert np.median(np.abs(found - slopes[:, k])) < 0.01 * np.abs(slopes[:, k]).max()


@cache
def analysed(turn_deg: float) -> Analysis:
    """The whole analysis, at a noise of 0.02 on every pixel."""
    return analyse(turning(turn_deg, sigma=0.02, frames=500))


@pytest.mark.parametrize("turn_deg", [pytest.param(20.0, marks=pytest.mark.thorough), 90.0])
def test_angle_and_image_of_an_object_that_turns(turn_deg: float) -> None:
    """Half a degree; and an image within 3 dB of that of the object at rest."""
    found, at_rest = analysed(turn_deg), analysed(0.0)

    assert found.trajectory is not None
    assert found.trajectory.angle_deg is not None
    error_deg = found.trajectory.angle_deg - turn_deg * np.arange(500) / 500
    assert float(np.sqrt(np.mean(error_deg**2))) < 0.5
    assert found.figures.psnr_db is not None
    assert at_rest.figures.psnr_db is not None
    assert found.figures.psnr_db > at_rest.figures.psnr_db - 3
    assert found.figures.turn_deg == pytest.approx(float(found.trajectory.angle_deg[-1]))
    assert found.trajectory.angle_sigma_deg is not None
    assert found.figures.turn_sigma_deg == pytest.approx(float(found.trajectory.angle_sigma_deg[-1]))
    assert "degrees clockwise" in found.figures.rows()["turn"]
    assert found.refinements > 0


def test_methods_whose_rows_do_not_turn_are_refused() -> None:
    with pytest.raises(InputError, match="the method dgi for an object that turns"):
        analyse(turning(0.0, frames=20), method="dgi")


def test_a_path_without_an_angle_is_refused() -> None:
    measurement = first_light(turning(0.0, frames=20))
    path = Trajectory(np.zeros((20, 2)), np.zeros((20, 2)), 3e-4, "given", np.ones(20, np.bool_))
    with pytest.raises(InputError, match="a trajectory without an angle"):
        refine_turn(measurement, path)
