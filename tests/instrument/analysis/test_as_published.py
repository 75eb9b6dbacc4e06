"""What the analysis takes over from the paper as it stands, and what a person may choose beside it."""

from dataclasses import replace

import numpy as np
import pytest

from instrument import simulate
from instrument.analysis import analyse
from instrument.measurement import Measurement
from instrument.recording import Recording
from instrument.tracking import track
from protocols import Floats, InputError
from tests.support.motions import letter_b
from tests.support.plans import plan_of


def _run(**scene: object) -> Recording:
    plan = plan_of("fourier-hadamard", frames=80, image_size=64)

    def path(time_s: Floats) -> Floats:
        return np.outer(time_s / plan.run_time_s, [12.0, 8.0])

    return simulate(plan, {"noise": {"kind": "none"}, **scene}, image=letter_b(4, 4, 64), path=path)


def test_per_frame_is_equation_6_of_the_values_and_nothing_else() -> None:
    """Of a bench with a leak and a lamp that flickers: O~ = (2 I_0 - S) + j (2 I_90 - S), and the unwrapped phase over 2 pi f."""
    recording = _run(mirror_transition_s=6e-6, led_flicker=0.2)
    values = recording.values
    total = values[:, 4] + values[:, 5]
    signals = [(2 * values[:, k] - total) + 1j * (2 * values[:, k + 1] - total) for k in (0, 2)]
    expected = np.stack([-np.unwrap(np.angle(z * np.conj(z[0]))) * 64 / 2 / (2 * np.pi) for z in signals], axis=1)

    np.testing.assert_allclose(track(recording, "per-frame").displacement_px, expected, atol=1e-9)
    found = analyse(recording, tracking="per-frame", method="conventional")
    assert found.trajectory is not None
    np.testing.assert_allclose(found.trajectory.displacement_px, expected, atol=1e-9)
    assert found.light.leak.value == 0


def test_five_neighbours_are_averaged_where_that_is_asked_for() -> None:
    recording = _run()
    found = analyse(recording, tracking="per-frame", method="conventional", mean_filter=5).trajectory
    assert found is not None
    np.testing.assert_array_equal(found.displacement_px, track(recording, "per-frame", mean_filter=5).displacement_px)
    with pytest.raises(InputError, match="a mean filter of 5 for the tracking smooth"):
        analyse(recording, tracking="smooth", mean_filter=5)


def test_values_are_divided_by_each_frames_own_light_or_not_at_all() -> None:
    """A lamp that flickers by 20 %: divided by its own total, a frame's H+ and H- add to the mean total."""
    measurement = Measurement.of(_run(led_flicker=0.2))
    total = measurement.total
    by_frame, by_nothing = (replace(measurement, normalise="frame"), replace(measurement, normalise="off"))
    for chosen, expected in ((by_frame, np.full(80, total.mean())), (by_nothing, total)):
        values = chosen.image_values(steady_object=True)
        np.testing.assert_allclose(values.positive + values.negative, expected, rtol=1e-9)
