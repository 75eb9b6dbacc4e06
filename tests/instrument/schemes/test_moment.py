"""What the three patterns of Zha 2021 and the four of Zha 2022 are, and what their values mean."""

import numpy as np
import pytest

from instrument.patterns import ramp
from instrument.schemes import moment_reading, position_of, scheme_of
from instrument.tracking import track
from protocols import Floats
from tests.support.motions import letter_b
from tests.support.plans import plan_of
from tests.support.simulation import simulate

SCHEMES = ("moment", "moment-complementary")


def test_three_moments_by_hand() -> None:
    """S = m00 = 10 and m = 8: the centroid is 8 x 5 / 10 - 1/2 = 3.5 px and 8 x 2.5 / 10 - 1/2 = 1.5 px."""
    scheme = scheme_of(plan_of("moment", frames=1, image_size=8))
    values = np.array([[10.0, 5.0, 2.5]])
    total = values @ scheme.light_weights

    assert total.tolist() == [10.0]
    np.testing.assert_allclose(position_of(scheme).signal(values, total), [[3.5, 1.5]], atol=1e-12)
    assert position_of(scheme).period_px is None


def test_complementary_moments_by_hand() -> None:
    """By x = I / (I + I') = 5 / 10 of 8 px, less half a pixel: 3.5 px; y = 2.5 / 10 of 8 px, less half: 1.5 px."""
    scheme = scheme_of(plan_of("moment-complementary", frames=1, image_size=8))
    values = np.array([[5.0, 5.0, 2.5, 7.5]])
    total = values @ scheme.light_weights

    assert total.tolist() == [10.0]
    np.testing.assert_allclose(position_of(scheme).signal(values, total), [[3.5, 1.5]], atol=1e-12)
    assert position_of(scheme).period_px is None


def test_the_centroid_of_a_complementary_pair_is_the_published_ratio_whatever_the_noise() -> None:
    """I / (I + I') of each axis, where both axes see as much light: the least squares of two values is no other formula."""
    values = np.random.default_rng(2).uniform(1, 9, (50, 4))
    values[:, 3] = values[:, 0] + values[:, 1] - values[:, 2]
    scheme = scheme_of(plan_of("moment-complementary", frames=1, image_size=16))

    found = position_of(scheme).signal(values, values @ scheme.light_weights)

    x, y = (values[:, k] / (values[:, k] + values[:, k + 1]) for k in (0, 2))
    np.testing.assert_allclose(found, 16 * np.stack([x, y], axis=1) - 0.5, atol=1e-10)


def test_a_complement_sees_what_its_ramp_leaves() -> None:
    columns = scheme_of(plan_of("moment-complementary", frames=1, image_size=8)).columns
    reading = moment_reading(columns, 8)

    assert [(c.role, c.axis, c.sign) for c in columns] == [
        ("moment", "x", 1),
        ("moment", "x", -1),
        ("moment", "y", 1),
        ("moment", "y", -1),
    ]
    np.testing.assert_allclose(reading.base, [[1 / 16, 15 / 16]] * 2)
    np.testing.assert_allclose(reading.response[..., 0], [[1 / 8, -1 / 8]] * 2)


@pytest.mark.parametrize("name", SCHEMES)
def test_a_lit_pixel_is_found_where_it_is_by_grey_ramps(name: str) -> None:
    """Row 2, column 5, of transmission 0.7: any centroid is that pixel, however bright."""
    image = np.zeros((8, 8))
    image[2, 5] = 0.7
    x, y = float((image * ramp(8, "x")).sum()), float((image * ramp(8, "y")).sum())
    values = np.array([[0.7, x, y] if name == "moment" else [x, 0.7 - x, y, 0.7 - y]])
    scheme = scheme_of(plan_of(name, frames=1, image_size=8))

    np.testing.assert_allclose(position_of(scheme).signal(values, values @ scheme.light_weights), [[5, 2]], atol=1e-12)


@pytest.mark.parametrize(("name", "planes"), [("moment", 4), ("moment-complementary", 5)])
def test_a_run_has_as_many_unique_patterns_as_a_frame_and_a_dark_guard(name: str, planes: int) -> None:
    sequence = scheme_of(plan_of(name, frames=200, image_size=32)).sequence()

    assert len(np.unique(sequence.planes.reshape(planes, -1), axis=0)) == planes
    assert len(sequence.play_order) == (planes - 1) * 200 + 1
    assert sequence.play_order[-1] == planes - 1
    assert not sequence.sample_plane(planes - 1).any()
    assert sequence.samples == 64


def test_the_patterns_are_all_on_and_the_ramps_and_complements_add_to_it() -> None:
    three = scheme_of(plan_of("moment", frames=1, image_size=32)).fixed_patterns
    four = scheme_of(plan_of("moment-complementary", frames=1, image_size=32)).fixed_patterns

    assert three[0].all()
    np.testing.assert_array_equal(four[0], three[1])
    np.testing.assert_array_equal(four[2], three[2])
    np.testing.assert_array_equal(four[0] + four[1], np.ones((64, 64)))
    np.testing.assert_array_equal(four[2] + four[3], np.ones((64, 64)))
    assert three[1][:, -8:].mean() > 0.9, "the ramp along x grows along columns"
    assert three[2][-8:].mean() > 0.9, "the ramp along y grows along rows"


@pytest.mark.parametrize("name", SCHEMES)
def test_a_lamp_that_flickers_moves_nothing(name: str) -> None:
    """By 30 %, slowly against a frame: positions are shares of the light."""

    def still(time_s: Floats) -> Floats:
        return np.zeros((len(time_s), 2))

    plan = plan_of(name, frames=60, image_size=64)
    recording = simulate(plan, letter_b(size=64), still, light=lambda time_s: 1 + 0.3 * np.sin(30 * time_s))

    assert np.abs(track(recording, "per-frame").displacement_px).max() < 0.1
