# pyright: reportPrivateUsage=false
"""Detail as fine as a pixel, and the path that shows it."""

from dataclasses import replace

import numpy as np
import pytest

from instrument.joint.detail import Picture, _plain, in_detail
from instrument.joint.iterate import Iterate
from instrument.measurement import first_light
from instrument.numerics import offset_free_mse
from instrument.plan import Plan
from instrument.reconstruction import Problem, binned
from instrument.recording import Recording
from instrument.schemes import FourierHadamardSettings
from instrument.tracking import as_trajectory
from protocols import Floats
from tests.support.simulation import simulate

FRAMES, SIZE = 400, 64


def _path(time_s: Floats) -> Floats:
    part = time_s / (FRAMES * 3e-4)
    return np.stack([14 * part + 3 * part**2, 15 * part + 2 * part**2], axis=1)


def _stripes() -> Floats:
    """Five bars of 1 px, 1 px apart, 16 px long: each as thick as the patterns' pixels."""
    image = np.zeros((SIZE, SIZE))
    image[20:36, 20:29:2] = 1.0
    return image


def _square() -> Floats:
    image = np.zeros((SIZE, SIZE))
    image[18:34, 18:34] = 1.0
    return image


def _recorded(image: Floats, sigma: float) -> Recording:
    plan = Plan(frames=FRAMES, image_size=SIZE, scheme=FourierHadamardSettings(hadamard_order="hyperbolic"))
    return simulate(plan, image, path=_path, sigma=sigma, seed=3)


def _along(recording: Recording, shaken_px: float) -> Iterate:
    """State the problem along the true path, shaken with a correlation over ten frames or so."""
    assert recording.truth is not None
    noise = np.random.default_rng(4).standard_normal((FRAMES + 19, 2))
    shaking = np.stack([np.convolve(noise[:, axis], np.full(20, 20**-0.5), "valid") for axis in range(2)], axis=1)
    measurement = first_light(recording)
    trajectory = as_trajectory(recording.truth.displacement_px + shaken_px * shaking, FRAMES, measurement.frame_time_s)
    values = measurement.image_values(steady_object=True)
    return Iterate(measurement, Problem.of(measurement, values, trajectory, region="inside", grid=2), trajectory)


@pytest.fixture(scope="module")
def stripes() -> Recording:
    return _recorded(_stripes(), 0.03)


def _contrast(picture: Picture) -> float:
    image = picture.iterate.problem.region.paste(picture.state.image.astype(np.float64), SIZE)
    bars, gaps = (float(binned(image, 2)[20:36, first:29:2].mean()) for first in (20, 21))
    return (bars - gaps) / (bars + gaps)


def test_stripes_of_a_pixel_get_the_contrast_that_smoothing_took_even_along_a_shaken_path(stripes: Recording) -> None:
    usual = Picture.of(_along(stripes, 0.4))
    found = in_detail(usual, fitted=False)
    assert stripes.truth is not None
    before, after = (
        offset_free_mse(picture.iterate.trajectory.displacement_px, stripes.truth.displacement_px)
        for picture in (usual, found)
    )
    assert _contrast(usual) < 0.4
    assert _contrast(found) > 0.8
    assert after < before / 8
    assert found.strength == usual.strength / 4
    assert found.state.misfit < 0.9


def test_a_plain_path_counts_from_the_frame_that_the_shaken_one_counts_from() -> None:
    """A parabola and shaking from frame to frame, relative to frame 300: the image is that of the same frame."""
    frame = np.arange(FRAMES) - 300.0
    parabola_px = np.outer(1e-4 * frame**2, [1.0, -2.0])
    shaken = as_trajectory(parabola_px + 0.1 * (-1.0) ** np.abs(frame)[:, None], FRAMES, 3e-4)
    found = _plain(replace(shaken, reference_frame=300)).displacement_px
    assert found[300].tolist() == [0, 0]
    np.testing.assert_allclose(found, parabola_px, atol=0.02)


def test_along_the_true_path_nothing_is_made_plain(stripes: Recording) -> None:
    """The true path explains more than a polynomial with its residuals does: refinement begins from it."""
    usual = Picture.of(_along(stripes, 0.0))
    found = in_detail(usual, fitted=False)
    assert stripes.truth is not None
    assert _contrast(found) > 0.8
    assert offset_free_mse(found.iterate.trajectory.displacement_px, stripes.truth.displacement_px) < 0.003


def test_where_the_usual_image_explains_what_was_measured_it_is_kept() -> None:
    usual = Picture.of(_along(_recorded(_square(), 0.1), 0.0))
    assert in_detail(usual, fitted=False) is usual


@pytest.mark.parametrize(("misfit", "believed"), [(1.88, False), (1.87, True)])
def test_less_smoothing_is_believed_from_an_eighth_less_of_squared_misfit_on(
    stripes: Recording, misfit: float, *, believed: bool
) -> None:
    """2^2 (1 - 0.12) = 3.52 = 1.876^2."""
    usual = Picture.of(_along(stripes, 0.0))
    two, other = (replace(usual, state=replace(usual.state, misfit=value)) for value in (2.0, misfit))
    assert other.explains_more_than(two) is believed
