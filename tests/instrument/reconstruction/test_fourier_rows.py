"""The Fourier values as rows, against patterns moved back one by one."""

import numpy as np
import pytest

from instrument.plan import Plan
from instrument.reconstruction import Field, FixedPatterns, Method, Region, reconstruct
from instrument.reconstruction.fourier_rows import FourierRows
from instrument.schemes import scheme_of
from protocols import Floats
from tests.support.dense import seen_patterns
from tests.support.simulation import simulate

SIZE, FRAMES = 16, 40
REGION = Region(top=2, left=1, height=9, width=8)
PLAN = Plan(frames=FRAMES, image_size=SIZE)
FREQUENCY_PER_PX = 2 / SIZE


def _places() -> Floats:
    return np.random.default_rng(0).uniform(0, 5, (FRAMES, 4, 2))


def _rows() -> tuple[FourierRows, Floats]:
    sigma = np.random.default_rng(1).uniform(0.5, 2, (FRAMES, 4))
    fixed = FixedPatterns.of(Field(SIZE).acting(scheme_of(PLAN).fixed_patterns), Field(SIZE), REGION, _places())
    return FourierRows.of(fixed, _places(), sigma, FREQUENCY_PER_PX, (0, 0, 1, 1)), sigma


def test_rows_are_whitened_patterns_moved_back_without_what_goes_as_the_grey_fringes() -> None:
    rows, sigma = _rows()
    part = np.random.default_rng(2).random(REGION.shape)
    image = REGION.paste(part, SIZE)
    patterns = scheme_of(PLAN).fixed_patterns.astype(np.float64)
    expected = np.empty((FRAMES, 4))
    for k in range(4):
        seen = (seen_patterns(np.repeat(patterns[k : k + 1], FRAMES, 0), _places()[:, k]) * image).sum(axis=(1, 2))
        angle = 2 * np.pi * FREQUENCY_PER_PX * _places()[:, k, k // 2]
        grey = np.stack([np.ones(FRAMES), np.cos(angle), np.sin(angle)], axis=1) / sigma[:, k : k + 1]
        series = seen / sigma[:, k]
        expected[:, k] = series - grey @ np.linalg.lstsq(grey, series)[0]

    assert np.allclose(rows.matvec(part.astype(np.float32).ravel()), expected.ravel(), atol=1e-3)


def test_matvec_and_rmatvec_are_each_others_transpose() -> None:
    rows, _ = _rows()
    rng = np.random.default_rng(4)
    image, values = (rng.standard_normal(count).astype(np.float32) for count in reversed(rows.shape))
    left, right = np.vdot(rows.matvec(image), values), np.vdot(image, rows.rmatvec(values))
    assert left == pytest.approx(right, rel=1e-3)


def test_where_the_noise_is_weak_they_make_the_image_better() -> None:
    """Grey blocks of 4 px, noise of a quarter of the paper's, with the true motion: at least 1 dB."""
    image = np.zeros((64, 64))
    image[8:32, 10:34] = np.random.default_rng(0).random((6, 6)).repeat(4, 0).repeat(4, 1)
    plan = Plan(frames=400, image_size=64)
    recording = simulate(plan, image, lambda t: t[:, None] * [200.0, 150.0], sigma=0.025, seed=1)
    assert recording.truth is not None
    motion, truth = recording.truth.displacement_px, recording.truth.image

    def error_db(method: Method) -> float:
        found = reconstruct(recording, motion, method)
        return float(10 * np.log10(np.mean((np.clip(found.image, 0, 1) - truth) ** 2)))

    assert error_db("tv-fourier") < error_db("tv") - 1
