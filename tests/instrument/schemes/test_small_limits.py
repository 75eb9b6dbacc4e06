"""Without noise, the newer schemes leave the error of their dithered patterns too, for any object on any smooth motion.

The limits are those of ``test_dithering_limits`` for the same patterns in 128 px: in 64 px a ramp errs by half as much, and a
fringe of one period is the same as one of two in 128 px.
"""

from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from instrument.numerics import displacement_mse
from instrument.tracking import StreamingTracker, track
from tests.support.objects import scenes
from tests.support.plans import plan_of
from tests.support.simulation import simulate

LIMITS: dict[str, tuple[dict[str, Any], float]] = {
    "fourier-4step": ({"fourier_cycles": 1}, 0.11),
    "moment": ({"upsampling": 2}, 0.70),
    "moment-complementary": ({"upsampling": 2}, 0.70),
    "moment-rotation": ({"upsampling": 2}, 0.70),
}
"""Settings, and what the MSE of one run never exceeds, px^2."""


@pytest.mark.parametrize("scheme", LIMITS)
def test_any_object_on_any_smooth_motion_is_followed_within_the_dithering_limit(scheme: str) -> None:
    own, most = LIMITS[scheme]
    plan = plan_of(scheme, frames=120, image_size=64, **own)

    @settings(max_examples=8, deadline=None, suppress_health_check=[HealthCheck.too_slow])
    @given(data=st.data())
    def within(data: st.DataObject) -> None:
        scene = data.draw(scenes(64, plan.run_time_s))
        recording = simulate(plan, scene.image, scene.path)
        assert recording.truth is not None
        for found in (
            track(recording, "per-frame").displacement_px,
            track(recording).displacement_px,
            StreamingTracker(plan).push(recording.values),
        ):
            assert displacement_mse(found, recording.truth.displacement_px) < most

    within()
