"""A field that is darker in its corners: with the profile, path and image are nearly what they are in an even one."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from instrument import simulate
from instrument.config import LightTable
from instrument.joint import Refined, refine
from instrument.measurement import first_light
from instrument.numerics import displacement_mse, psnr
from instrument.plan import Plan
from instrument.reconstruction import Problem, reconstruct
from instrument.recording import Recording
from instrument.tracking import as_trajectory, track
from protocols import Floats, Truth

FRAMES, SIZE = 400, 64
_SQUARED = (1.0, 0.25, 0.0, 0.25, 1.0)
TABLE = LightTable(profile=tuple(tuple(1 - 0.3 * (y + x) for x in _SQUARED) for y in _SQUARED))
"""0.4 in the corners, 0.7 in the middle of each side."""


def _path(time_s: Floats) -> Floats:
    part = time_s / (FRAMES * 3e-4)
    return np.stack([22 * part + 4 * part**2, 20 * part + 6 * part**2], axis=1)


def _object() -> Floats:
    image = np.zeros((SIZE, SIZE))
    image[8:28, 8:13] = 1.0
    image[8:12, 8:26] = 1.0
    image[20:28, 18:26] = 1.0
    return image


@cache
def _recorded() -> tuple[Recording, Truth]:
    scene = {"noise": {"kind": "pixel", "sigma": 0.03, "seed": 5}, "illumination_falloff": 0.6}
    recording = simulate(Plan(frames=FRAMES, image_size=SIZE), scene, image=_object(), path=_path)
    assert recording.truth is not None
    return recording, recording.truth


@cache
def _refined(*, told: bool) -> Refined:
    recording, _ = _recorded()
    recording = replace(recording, light=TABLE) if told else recording
    return refine(recording, track(recording))


def test_path_and_image_are_better_where_the_profile_is_told() -> None:
    _, truth = _recorded()
    blind, told = _refined(told=False), _refined(told=True)
    before, after = (
        displacement_mse(found.trajectory.displacement_px, truth.displacement_px) for found in (blind, told)
    )
    assert after < before / 5
    assert psnr(told.image.at_patterns, _object()) > psnr(blind.image.at_patterns, _object()) + 3
    assert told.image.unknowns is not None
    of_all_values = told.image.misfit * (1 - told.image.unknowns / len(told.measurement)) ** 0.5
    assert of_all_values < 1.1
    assert told.image.misfit < blind.image.misfit


def test_the_image_is_that_of_the_object_not_of_its_light() -> None:
    """It is as bright in the corner of the field as elsewhere, where the light falls to half."""
    image = _refined(told=True).image.at_patterns
    assert image[14:26, 9:12].mean() == pytest.approx(1.0, abs=0.04)
    assert image[22:26, 20:24].mean() == pytest.approx(1.0, abs=0.04)


def test_a_path_that_is_known_is_enough_for_the_image() -> None:
    recording, truth = _recorded()
    found = reconstruct(replace(recording, light=TABLE), truth.displacement_px)
    assert psnr(found.at_patterns, _object()) > psnr(reconstruct(recording, truth.displacement_px).image, _object()) + 3


def test_light_that_the_object_lets_through_less_of_at_the_border_is_no_lamp_that_fades() -> None:
    """The values get back the total light that an object has in each place, and no more when that is asked for again."""
    recording, truth = _recorded()
    measurement = first_light(replace(recording, light=TABLE))
    trajectory = as_trajectory(truth.displacement_px, FRAMES, measurement.frame_time_s)
    values = measurement.image_values(steady_object=True)
    problem = Problem.of(measurement, values, trajectory, region="inside")
    area = problem.region
    part = _object()[area.top : area.top + area.height, area.left : area.left + area.width]
    once = problem.seen_as(part, None)
    total = once.values.positive + once.values.negative
    arrived = measurement.total / measurement.total.mean()
    assert np.corrcoef(total, arrived)[0, 1] > 0.99
    np.testing.assert_allclose(once.seen_as(part, None).values.positive, once.values.positive, rtol=1e-9)
    np.testing.assert_allclose(once.remeasured(measurement).values.fixed, once.values.fixed, rtol=1e-9)


def test_patterns_without_a_position_see_the_object_where_hadamard_patterns_do() -> None:
    """An object at rest has the same light throughout: nothing is taken off its values."""
    plan = Plan.model_validate({"frames": 300, "image_size": SIZE, "scheme": "hadamard"})
    scene = {"noise": {"kind": "pixel", "sigma": 0.03, "seed": 5}, "illumination_falloff": 0.6}
    recording = replace(simulate(plan, scene, image=_object()), light=TABLE)
    measurement = first_light(recording)
    at_rest = as_trajectory(np.zeros((300, 2)), 300, measurement.frame_time_s)
    problem = Problem.of(measurement, measurement.image_values(steady_object=True), at_rest, region="inside")
    assert problem.places.middle_px == pytest.approx(np.zeros((300, 2)))
    seen = problem.seen_as(_object(), None).seen
    assert seen == pytest.approx(np.ones(300))
