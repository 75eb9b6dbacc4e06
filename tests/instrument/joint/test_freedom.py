"""The unknowns of an image, counted by a probe, and the misfit of the values that are left over beside them."""

from dataclasses import replace

import numpy as np
import pytest

from instrument.joint.detail import Picture
from instrument.joint.freedom import freedom_of
from instrument.joint.iterate import Iterate
from instrument.measurement import first_light
from instrument.plan import Plan
from instrument.reconstruction import Problem
from instrument.tracking import as_trajectory
from protocols import Floats
from tests.support.simulation import simulate

FRAMES, SIZE = 200, 32


def _iterate(patch: Floats) -> Iterate:
    """Ten by ten pixels along their true path."""
    image = np.zeros((SIZE, SIZE))
    image[6:16, 7:17] = patch

    def path(time_s: Floats) -> Floats:
        return np.stack([100 * time_s, 80 * time_s], axis=1)

    recording = simulate(Plan(frames=FRAMES, image_size=SIZE), image, path=path, sigma=0.03, seed=5)
    assert recording.truth is not None
    measurement = first_light(recording)
    trajectory = as_trajectory(recording.truth.displacement_px, FRAMES, measurement.frame_time_s)
    values = measurement.image_values(steady_object=True)
    return Iterate(measurement, Problem.of(measurement, values, trajectory, region="inside"), trajectory)


@pytest.fixture(scope="module")
def iterate() -> Iterate:
    """A hundred pixels, each of a transmission of its own."""
    return _iterate(np.random.default_rng(2).uniform(0.1, 1.0, (10, 10)))


def test_what_is_left_is_held_against_the_values_that_are_left_over(iterate: Iterate) -> None:
    picture = Picture.of(iterate, strength=0.3)
    found = freedom_of(picture)
    assert 25 < found.unknowns < 100
    assert found.misfit == pytest.approx(picture.state.misfit / (1 - found.unknowns / FRAMES) ** 0.5)


def test_a_square_has_few_unknowns_and_leaves_the_noise() -> None:
    found = freedom_of(Picture.of(_iterate(np.ones((10, 10)))))
    assert 0 < found.unknowns < 20
    assert found.misfit == pytest.approx(1.0, abs=0.15)


def test_an_image_that_is_smoothed_less_has_more_unknowns(iterate: Iterate) -> None:
    smooth, rough = (freedom_of(Picture.of(iterate, strength)) for strength in (12.0, 0.3))
    assert rough.unknowns > smooth.unknowns + 10


def test_a_misfit_that_is_not_known_stays_so(iterate: Iterate) -> None:
    picture = Picture.of(iterate)
    unknown = replace(picture, state=replace(picture.state, misfit=float("nan")))
    assert np.isnan(freedom_of(unknown).misfit)
