"""Recordings of moving objects into images."""

from dataclasses import replace
from typing import get_args

import numpy as np
import pytest

from instrument.measurement import Measurement
from instrument.plan import Plan
from instrument.reconstruction import Method, Region, reconstruct
from instrument.recording import Recording
from protocols import Floats, InputError, Truth
from tests.support.simulation import simulate

SIZE = 64
FRAMES = 600


def _object() -> Floats:
    """A square with a hole, 0.6 beside 1."""
    image = np.zeros((SIZE, SIZE))
    image[8:26, 10:28] = 1.0
    image[13:20, 15:22] = 0.0
    image[8:26, 28:34] = 0.6
    return image


def _plan(frames: int = FRAMES) -> Plan:
    return Plan(frames=frames, image_size=SIZE)


def _drift(time_s: Floats) -> Floats:
    return time_s[:, None] * [120.0, 90.0]


def _run(sigma: float = 0.05, **options: float) -> Recording:
    return simulate(_plan(), _object(), _drift, sigma=sigma, peak_counts=options.get("peak_counts"), seed=1)


def _truth(recording: Recording) -> Truth:
    assert recording.truth is not None
    return recording.truth


def _psnr(image: Floats, truth: Floats) -> float:
    return float(-10 * np.log10(np.mean((np.clip(image, 0, 1) - truth) ** 2)))


def test_the_image_is_sharp_with_the_motion_and_blurred_without() -> None:
    recording = _run()
    truth = _truth(recording)
    image = reconstruct(recording, truth.displacement_px)
    assert image.misfit == pytest.approx(1.0, abs=0.1)
    assert _psnr(image.image, truth.image) > 31
    assert _psnr(reconstruct(recording, np.zeros((FRAMES, 2))).image, truth.image) < 20


def test_without_noise_the_image_is_near_exact() -> None:
    recording = _run(sigma=0.0)
    truth = _truth(recording)
    assert _psnr(reconstruct(recording, truth.displacement_px).image, truth.image) > 50


def test_wrong_motion_without_noise_ends_soon_with_a_fair_image_and_a_misfit_that_tells() -> None:
    """A tenth of a pixel of error in a run without noise: no image explains it, so the solver must not go on trying."""
    recording = _run(sigma=0.0)
    truth = _truth(recording)
    error = 0.1 * np.sin(np.arange(FRAMES) / 5.0)
    image = reconstruct(recording, truth.displacement_px + error[:, None])
    assert image.iterations <= 600
    assert image.misfit > 2
    assert _psnr(image.image, truth.image) > 31


def test_differences_of_photons_weigh_by_the_mean_light_and_not_by_the_count() -> None:
    """100 photons a frame in steady light: the variance of each difference is 100, whatever was counted."""
    values = Measurement.of(_run(peak_counts=100.0, sigma=0.0)).image_values(steady_object=True)
    assert (values.positive + values.negative).std() > 8
    assert values.difference_sigma == pytest.approx(10.0, rel=0.05)
    assert values.difference_sigma.std() < 0.2


def test_methods_rank_as_expected() -> None:
    """At this noise: edges freed, then Bregman, then the ghost image, then no motion at all."""
    recording = _run()
    truth = _truth(recording)
    ranks = {
        method: _psnr(reconstruct(recording, truth.displacement_px, method).image, truth.image)
        for method in get_args(Method)
    }
    assert ranks["tv"] > ranks["tv-bregman"] > ranks["dgi"] > ranks["conventional"]
    assert ranks["dgi"] > 14


def test_each_pattern_of_a_fast_object_is_taken_at_its_own_place() -> None:
    """A circle at 3 px a frame: a chord of 14 sin(pi 40 / 600) px. H+ and H- are half a pixel apart."""

    def circle(time_s: Floats) -> Floats:
        angle = 2 * np.pi * 40 / (FRAMES * 300e-6) * time_s
        return 7 * np.stack([np.cos(angle) - 1, np.sin(angle)], axis=1) + [12.0, 0.0]

    recording = simulate(_plan(), np.roll(_object(), 14, 0), circle, sigma=0.02, seed=3)
    truth = _truth(recording)
    assert np.hypot(*np.diff(truth.displacement_px, axis=0).T).max() == pytest.approx(
        2.911, abs=0.001
    )  # chord: 14 sin(pi 40 / 600)
    assert _psnr(reconstruct(recording, truth.displacement_px).image, truth.image) > 30


def test_frames_that_are_not_valid_are_left_out() -> None:
    recording = _run()
    truth = _truth(recording)
    values, valid = recording.values.copy(), recording.frame_valid.copy()
    values[50:80] = 1e6
    valid[50:80] = False
    values[100, 4] = np.nan  # not marked, but not a number
    image = reconstruct(replace(recording, values=values, frame_valid=valid), truth.displacement_px)
    assert _psnr(image.image, truth.image) > 30


def test_photon_counts_have_no_scale_of_their_own_so_the_brightest_pixel_is_one() -> None:
    recording = _run(peak_counts=2e5, sigma=0.0)
    truth = _truth(recording)
    image = reconstruct(recording, truth.displacement_px)
    assert image.image.max() == pytest.approx(1.0)
    # 2e5 counts of an all-on pattern over the light of the whole object
    assert image.gain == pytest.approx(2e5 / _object().sum(), rel=0.05)
    assert _psnr(image.image, truth.image) > 30


def test_a_lamp_that_fades_does_not_fade_the_image() -> None:
    """Light falls to a half over the run: divided out where the object is known to stay inside."""
    fading = simulate(_plan(), _object(), _drift, sigma=0.02, light=lambda t: 1 - t / (2 * FRAMES * 300e-6), seed=1)
    truth = _truth(fading)
    image = reconstruct(fading, truth.displacement_px).image
    best = float(np.vdot(image, truth.image) / np.vdot(image, image))
    assert _psnr(best * image, truth.image) > 30
    assert best == pytest.approx(1 / 0.75, rel=0.05)  # values are on the scale of the mean light, 3/4
    # Taken as steady, the light costs 15 dB and more, and the misfit says that something is wrong.
    steady = reconstruct(fading, truth.displacement_px, region="field")
    assert _psnr(steady.image, truth.image) < _psnr(best * image, truth.image) - 15
    assert steady.misfit > 1.5


def test_an_object_that_leaves_the_field_is_imaged_without_a_region() -> None:
    def away(time_s: Floats) -> Floats:
        return time_s[:, None] * [-160.0, 0.0]

    recording = simulate(_plan(), _object(), away, sigma=0.02, seed=1)
    truth = _truth(recording)
    assert truth.displacement_px[-1, 0] < -28
    image = reconstruct(recording, truth.displacement_px, region="field")
    assert image.region == Region.whole(SIZE)
    assert _psnr(image.image, truth.image) > 28


def test_the_image_is_an_array() -> None:
    recording = _run().first(40)
    image = reconstruct(recording, _truth(recording).displacement_px, "dgi")
    assert np.asarray(image).shape == (SIZE, SIZE)
    assert np.array_equal(np.asarray(image), image.image)


def test_displacements_of_another_run_are_refused() -> None:
    recording = _run()
    with pytest.raises(InputError, match=r"shape \(599, 2\)"):
        reconstruct(recording, _truth(recording).displacement_px[1:])


def test_displacements_that_are_not_finite_are_refused() -> None:
    recording = _run()
    motion = _truth(recording).displacement_px.copy()
    motion[3] = np.nan
    with pytest.raises(InputError, match="2 not finite"):
        reconstruct(recording, motion)


def test_a_recording_without_a_valid_frame_is_refused() -> None:
    recording = _run()
    with pytest.raises(InputError, match="no valid frame in a recording of 600"):
        reconstruct(replace(recording, frame_valid=np.zeros(FRAMES, bool)), _truth(recording).displacement_px)
