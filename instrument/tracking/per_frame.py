"""The tracker of the paper: each frame's own phase.

References:
    Li et al., "Single-pixel imaging of a translational object", Opt. Express (2023), equations 6, 8 and 9.
"""

import numpy as np

from instrument.recording import Recording
from instrument.tracking.coefficients import measured
from instrument.tracking.trajectory import Trajectory
from protocols import Floats, InputError


def track_per_frame(recording: Recording, *, reference_frames: int = 1, mean_filter: int = 1) -> Trajectory:
    """Take dx = -arg(O~ conj O~_ref) / (2 pi f) in every frame, unwrapped from frame to frame.

    Args:
        recording: of the six-pattern scheme.
        reference_frames: how many frames at the start make up O~_ref: more than 1 where the object rested.
        mean_filter: how many neighbouring coefficients are averaged (the paper: 5); odd, 1 for none.

    Raises:
        InputError: no usable frame, none among the reference frames, or a filter of even length.
    """
    if mean_filter < 1 or mean_filter % 2 == 0:
        raise InputError(
            saw=f"a mean filter of {mean_filter}", expected="an odd number of frames", remedy="take 1 or 5"
        )
    found = measured(recording, smooth_total=False)
    valid, series = found.valid, found.coefficient
    if not valid[:reference_frames].any():
        raise InputError(
            saw=f"no valid frame among the first {reference_frames}",
            expected="at least one, as displacement counts from there",
            remedy="use method='smooth', or more reference_frames if the object rested",
        )
    if mean_filter > 1:
        series = np.stack([np.convolve(column, np.ones(mean_filter), "same") for column in series.T], axis=1)
    resting = valid[:reference_frames]
    reference = series[:reference_frames][resting].mean(axis=0)
    index = np.arange(len(valid))
    turned: Floats = np.unwrap(np.angle(series[valid] * np.conj(reference)), axis=0)
    phase = np.stack([np.interp(index, index[valid], turned[:, axis]) for axis in range(2)], axis=1)

    variance = found.phase_variance(phase + np.angle(reference))
    from_reference = variance[:reference_frames][resting].mean(axis=0) / max(mean_filter, np.count_nonzero(resting))
    radians = 2 * np.pi * recording.plan.frequency_per_px
    displacement = (phase if reference_frames > 1 else phase - phase[0]) / -radians
    sigma = np.sqrt(variance / mean_filter + from_reference) / radians
    if reference_frames == 1:
        sigma[0] = 0.0
    return Trajectory(displacement, sigma, recording.frame_time_s, "per-frame", valid)
