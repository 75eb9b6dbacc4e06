"""Motion and image refined together: better than the tracker, with an honest uncertainty, never too smooth."""

from functools import cache

import numpy as np
import pytest

from instrument.joint import Refined, refine
from instrument.numerics import displacement_mse, offset_free_mse, psnr
from instrument.plan import Plan
from instrument.reconstruction import reconstruct
from instrument.recording import Recording
from instrument.schemes import FourierHadamardSettings
from instrument.tracking import Trajectory, track
from protocols import Floats, Truth
from tests.support.simulation import Path2D, simulate

SIZE = 64
FRAMES = 800
RUN_S = FRAMES * 300e-6


def _object() -> Floats:
    """A thick F of 24 px, 234 px of light: 86 times the noise of a value, as the letter of the benchmarks has it."""
    image = np.zeros((SIZE, SIZE))
    image[8:32, 10:16] = 1.0
    image[8:14, 10:26] = 1.0
    image[18:23, 10:22] = 1.0
    return image


def _arc(time_s: Floats) -> Floats:
    angle = np.pi / 2 * time_s / RUN_S
    path_px: Floats = 28 * np.stack([np.sin(angle), 1 - np.cos(angle)], axis=1)
    return path_px


def _straight(time_s: Floats) -> Floats:
    """The diagonal at v0 t + a t^2 / 2, as a stage accelerates."""
    part = time_s / RUN_S
    path_px: Floats = (20 * part + 6 * part**2)[:, None] * [1.0, 1.0]
    return path_px


def _vibrating(time_s: Floats) -> Floats:
    """The arc with 1 px of vibration, 100 periods in the run."""
    shake: Floats = np.sin(2 * np.pi * 100 * time_s / RUN_S)[:, None] * [1.0, 0.0]
    return _arc(time_s) + shake


@cache
def _run(seed: int, path: Path2D = _arc) -> tuple[Recording, Truth, Trajectory, Refined]:
    plan = Plan(frames=FRAMES, image_size=SIZE)
    recording = simulate(plan, _object(), path, sigma=0.06, seed=seed)
    assert recording.truth is not None
    tracked = track(recording)
    return recording, recording.truth, tracked, refine(recording, tracked)


def test_refinement_takes_away_most_of_what_the_tracker_leaves() -> None:
    """Dithering is an error of the tracker and none of the refinement."""
    runs = [_run(seed) for seed in range(3)]
    tracked = np.mean([offset_free_mse(t.displacement_px, truth.displacement_px) for _, truth, t, _ in runs])
    refined = np.mean([offset_free_mse(r.trajectory.displacement_px, truth.displacement_px) for _, truth, _, r in runs])
    assert refined < tracked / 2
    assert refined < 0.003


def test_the_image_is_better_than_with_the_motion_of_the_tracker() -> None:
    """Mean of three runs."""
    gains: list[float] = []
    for seed in range(3):
        recording, truth, tracked, refined = _run(seed)
        found = psnr(refined.image.image, truth.image)
        assert found > 31
        gains.append(found - psnr(reconstruct(recording, tracked).image, truth.image))
    assert np.mean(gains) > 0.5


def test_vibration_is_followed_not_smoothed_away() -> None:
    """1 px in sine has 0.5 px^2 of power in x, 0.25 over both axes."""
    _, truth, tracked, refined = _run(0, _vibrating)
    error = displacement_mse(refined.trajectory.displacement_px, truth.displacement_px)
    assert error < 0.1
    assert error <= displacement_mse(tracked.displacement_px, truth.displacement_px)


def test_the_uncertainty_covers_the_truth() -> None:
    inside = [
        np.abs(r.trajectory.displacement_px - truth.displacement_px)[1:] < 1.96 * r.trajectory.sigma_px[1:]
        for _, truth, _, r in (_run(seed, _straight) for seed in range(10))
    ]
    assert 0.90 <= np.mean(inside) <= 0.98
    sigma = _run(0)[3].trajectory.sigma_px
    assert not sigma[0].any()
    assert sigma[1:].min() > 0
    assert np.median(sigma) < 0.2


def test_a_run_too_short_to_refine_keeps_the_motion_it_was_given() -> None:
    recording, truth, _, _ = _run(0)
    motion = truth.displacement_px[:40]
    refined = refine(recording.first(40), motion)
    assert refined.refinements == 0
    assert np.array_equal(refined.trajectory.displacement_px, motion)


def test_it_ends_where_the_motion_stands() -> None:
    """The true motion is changed no more than its uncertainty, in few loops."""
    recording, truth, _, _ = _run(1)
    refined = refine(recording, truth.displacement_px)
    assert 1 <= refined.refinements < 4
    assert refined.image.misfit == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("counts", [100.0, pytest.param(400.0, marks=pytest.mark.thorough)])
def test_few_photons_make_the_motion_no_worse(counts: float) -> None:
    """Of an all-on pattern. Weighting by the counts that came, not by those expected, made it several times worse."""
    tracked: list[float] = []
    refined: list[float] = []
    for seed in range(4):
        recording = simulate(Plan(frames=FRAMES, image_size=SIZE), _object(), _arc, peak_counts=counts, seed=seed)
        assert recording.truth is not None
        motion = track(recording)
        found = refine(recording, motion).trajectory
        tracked.append(displacement_mse(motion.displacement_px, recording.truth.displacement_px))
        refined.append(displacement_mse(found.displacement_px, recording.truth.displacement_px))
    assert np.mean(refined) < np.mean(tracked)


@pytest.mark.parametrize("size", [32, 64])
def test_without_noise_the_motion_is_found_to_a_fiftieth_of_a_pixel(size: int) -> None:
    """Where the tracker is left with the error of dithering, 0.02 px^2 and more."""
    part = size / SIZE
    image = _object()[:: SIZE // size, :: SIZE // size]
    recording = simulate(Plan(frames=FRAMES, image_size=size), image, lambda time_s: part * _arc(time_s))
    assert recording.truth is not None
    tracked = track(recording)
    refined = refine(recording, tracked).trajectory
    assert displacement_mse(tracked.displacement_px, recording.truth.displacement_px) > 0.01
    assert displacement_mse(refined.displacement_px, recording.truth.displacement_px) < 0.0004


def test_on_the_full_field_haze_that_leaves_it_is_no_motion() -> None:
    """Offset-free; with the sum of the image for the light in view it was some fifty times as much as in the region."""
    recording, truth, tracked, _ = _run(0)
    refined = refine(recording, tracked, region="field").trajectory
    assert offset_free_mse(refined.displacement_px, truth.displacement_px) < 0.003


def test_motion_is_kept_where_an_unlucky_order_of_patterns_leads_refinement_astray() -> None:
    """The first 800 of Sylvester's order at 64 px vary too little along y: the image cannot tell where it is."""
    plan = Plan(frames=800, image_size=64, scheme=FourierHadamardSettings(hadamard_order="natural"))
    recording = simulate(plan, _object(), lambda t: np.stack([60 * t, 70 * t], axis=1), sigma=0.1, seed=1)
    tracked = track(recording)
    refined = refine(recording, tracked)
    assert recording.truth is not None
    before = displacement_mse(tracked.displacement_px, recording.truth.displacement_px)
    after = displacement_mse(refined.trajectory.displacement_px, recording.truth.displacement_px)
    assert after == before
    assert refined.refinements == 0
    assert refined.image.misfit < 1.1
