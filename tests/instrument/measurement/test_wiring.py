"""Values of inverted mirrors: S - I, without the noise of S."""

import numpy as np

from instrument.measurement.wiring import rewired
from instrument.plan import Plan
from instrument.schemes import scheme_of
from protocols import Floats

FRAMES = 200


def _inverted(noise: float) -> Floats:
    """Frames of total light 100, of which each position pattern shows 30, and H+ and H- 40 and 60."""
    values = np.tile([30.0, 30, 30, 30, 40, 60], (FRAMES, 1))
    values[:, 4:] += noise * np.random.default_rng(2).standard_normal((FRAMES, 2))
    return values


def test_position_values_get_what_their_complements_lack_of_the_total_without_its_noise() -> None:
    scheme = scheme_of(Plan(frames=FRAMES, image_size=32))
    mended = rewired(_inverted(1.0), "inverted", scheme)
    assert np.abs(mended[:, :4].mean() - 70) < 0.3
    assert mended[:, :4].std() < 0.3  # of a total with a noise of 1.4
    np.testing.assert_array_equal(mended[:, 4:], _inverted(1.0)[:, [5, 4]])


def test_frames_that_were_not_measured_stay_so() -> None:
    scheme = scheme_of(Plan(frames=FRAMES, image_size=32))
    values = _inverted(0.1)
    values[7] = np.nan
    mended = rewired(values, "inverted", scheme)
    assert np.isnan(mended[7]).all()
    assert np.isfinite(np.delete(mended, 7, axis=0)).all()
    np.testing.assert_array_equal(rewired(values[:7], "inverted", scheme)[:, 0], values[:7, 4:].sum(axis=1) - 30)
