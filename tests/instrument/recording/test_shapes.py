"""A recording is made of arrays that go together, or not at all."""

from typing import Any

import numpy as np
import pytest

from instrument.plan import Plan
from instrument.recording import Recording
from protocols import InputError

GOOD: dict[str, Any] = {
    "plan": Plan(frames=30, image_size=16),
    "values": np.ones((20, 6)),
    "frame_valid": np.ones(20, np.bool_),
    "picture_time_s": 50e-6,
}


def test_fewer_frames_than_planned_are_a_run_that_ended_early() -> None:
    recording = Recording(**GOOD)
    assert len(recording) == 20
    assert recording.frame_time_s == pytest.approx(300e-6)


@pytest.mark.parametrize(
    ("wrong", "saw"),
    [
        (
            {"values": np.ones((20, 5))},
            r"values of shape \(20, 5\); expected \(20, 6\): 20 frames of the scheme fourier-h",
        ),
        ({"values": np.ones(20)}, r"values of shape \(20,\); expected \(20, 6\)"),
        ({"frame_valid": np.ones(7, np.bool_)}, r"frame_valid of shape \(7,\); expected \(20,\)"),
        ({"edge_time_s": np.ones((19, 6))}, r"edge_time_s of shape \(19, 6\); expected \(20, 6\)"),
        ({"background": np.ones((20, 4))}, r"background of shape \(20, 4\); expected \(20, 6\)"),
        ({"plan": Plan(frames=5, image_size=16)}, "20 frames of values by a plan of 5"),
        ({"picture_time_s": 0.0}, "a picture time of 0 s"),
        ({"picture_time_s": float("nan")}, "a picture time of nan s"),
    ],
)
def test_arrays_that_do_not_go_together_are_refused_by_name(wrong: dict[str, Any], saw: str) -> None:
    with pytest.raises(InputError, match=saw):
        Recording(**{**GOOD, **wrong})
