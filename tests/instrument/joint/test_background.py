"""Whether something stands still behind the object, and both images where it does."""

import numpy as np
import pytest

from instrument.joint import Refined, refine
from instrument.joint.background import background_of
from instrument.measurement import first_light
from instrument.numerics import displacement_mse, psnr
from instrument.reconstruction import Problem, Reconstruction
from instrument.recording import Recording
from instrument.tracking import track
from tests.instrument.joint.behind import bar, recorded
from tests.support.motions import letter_b


def _seen(recording: Recording) -> tuple[bool, tuple[int, ...]]:
    """Whether there is one, and the numbers of images that were looked at for it."""
    measurement = first_light(recording)
    values = measurement.image_values(steady_object=True)
    problem = Problem.of(measurement, values, track(measurement), region="inside")
    there, state = background_of(measurement, problem)
    return there, () if state is None else (len(state.images),)


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_none_is_seen_where_there_is_none(seed: int) -> None:
    assert _seen(recorded(0.0, seed=seed))[0] is False


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_third_of_the_object_s_light_is_seen(seed: int) -> None:
    assert _seen(recorded(1 / 3, seed=seed)) == (True, (2,))


@pytest.mark.parametrize("share", [0.07, 0.1])
def test_a_tenth_of_the_object_s_light_and_less_is_seen_at_the_noise_of_the_paper(share: float) -> None:
    assert _seen(recorded(share)) == (True, (2,))


def test_what_moves_the_offsets_too_little_is_not_looked_for_and_what_is_below_the_noise_is_not_believed() -> None:
    """3 % of the object's light: offsets below 0.01. 10 % in three times the noise: one image explains the values."""
    assert _seen(recorded(0.03)) == (False, ())
    assert _seen(recorded(0.1, sigma=0.3)) == (False, (1,))


def test_in_a_centroid_no_background_can_be_told_from_the_object() -> None:
    assert _seen(recorded(1 / 3, scheme="moment-hadamard")) == (False, ())


@pytest.fixture(scope="module")
def both() -> tuple[Refined, Refined]:
    """Without and with a background."""
    without, with_one = (recorded(share) for share in (0.0, 1 / 3))
    return refine(without, track(without)), refine(with_one, track(with_one))


def test_the_object_is_as_good_as_without_a_background_and_the_background_is_found(
    both: tuple[Refined, Refined],
) -> None:
    alone, behind = both
    truth = recorded(0.0).truth
    assert truth is not None
    assert alone.image.still is None
    assert behind.image.still is not None
    assert behind.image.still.shape == (128, 128)
    assert psnr(behind.image.image, truth.image) > psnr(alone.image.image, truth.image) - 1
    assert psnr(behind.image.still, bar(1 / 3)) > 35
    assert behind.image.still.sum() == pytest.approx(bar(1 / 3).sum(), rel=0.15)
    assert displacement_mse(behind.trajectory.displacement_px, truth.displacement_px) < 0.04
    assert behind.image.misfit == pytest.approx(1.0, abs=0.1)


def test_a_background_is_fitted_or_left_where_that_is_asked_for() -> None:
    recording = recorded(1 / 3)
    tracked = track(recording)
    left = refine(recording, tracked, background="none")
    assert left.image.still is None
    assert left.image.misfit > 1.2
    clean = recorded(0.0)
    fitted: Reconstruction = refine(clean, track(clean), background="fit").image
    assert fitted.still is not None
    assert np.abs(fitted.still).sum() < 0.1 * letter_b().sum()
