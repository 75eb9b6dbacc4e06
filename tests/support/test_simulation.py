"""The oracle's shortcuts against a plain sum over pixels."""

import numpy as np

from instrument.plan import Plan
from instrument.schemes import FourierHadamardSettings, scheme_of
from protocols import Floats
from tests.support.simulation import shifted, simulate


def test_values_are_sums_of_pattern_times_moved_object() -> None:
    """All six patterns, at sub-pixel displacements, some of which push the object over the field's edge."""
    plan = Plan(frames=40, image_size=16, superpixel=2, scheme=FourierHadamardSettings(fourier_cycles=1, upsampling=2))
    image = np.random.default_rng(3).random((16, 16))

    def path(time_s: Floats) -> Floats:
        return np.stack([9.3 * np.sin(3000 * time_s), 17 - 3000 * time_s], axis=1)

    recording = simulate(plan, image, path)
    sequence = scheme_of(plan).sequence()
    planes = [sequence.sample_plane(int(k)).reshape(16, 2, 16, 2).mean(axis=(1, 3)) for k in sequence.play_order[:-1]]
    places: list[tuple[float, float]] = path((np.arange(240, dtype=np.float64) + 0.5) * 50e-6).tolist()
    plain = [float((shifted(image, dx, dy) * plane).sum()) for plane, (dx, dy) in zip(planes, places, strict=True)]

    np.testing.assert_allclose(recording.values.ravel(), plain, atol=1e-9)
