"""The tracker as published, which gives each frame's own position.

It is the paper's processing and nothing else: the values of each frame over its own total light (equations 8 and 9), the phase
against the reference (equation 6), unwrapped from frame to frame, and a mean filter on the coefficients where one is asked for.

References:
    Li et al., "Single-pixel imaging of a translational object", Opt. Express (2023), equations 6, 8 and 9.
"""

import numpy as np

from instrument.measurement import Measurement
from instrument.tracking.trajectory import Trajectory
from protocols import Floats, InputError


def track_per_frame(measurement: Measurement, *, reference_frames: int = 1, mean_filter: int = 1) -> Trajectory:
    """Give the displacement of every frame's signal from the reference, unwrapped from frame to frame.

    For the Fourier coefficient O~ it is dx = -arg(O~ conj O~_ref) / (2 pi f); for a centroid it is the difference.

    Args:
        measurement: measurement with a scheme that tracks.
        reference_frames: number of frames at the start whose mean is the reference: more than 1 where the object rested.
        mean_filter: number of neighbouring signals that are averaged (5 in the paper); odd, 1 for none.

    Raises:
        InputError: no frame is usable, none of the reference frames is, or the filter has an even length.
    """
    if mean_filter < 1 or mean_filter % 2 == 0:
        raise InputError(
            saw=f"a mean filter of {mean_filter}", expected="an odd number of frames", remedy="take 1 or 5"
        )
    if reference_frames < 1:
        raise InputError(
            saw=f"{reference_frames} reference frames",
            expected="1 or more",
            remedy="take 1, or as many as the object rested",
        )
    found = measurement.observe(steady=False, as_measured=True)
    valid, signal, reading = found.valid, found.signal, found.reading
    if not valid[:reference_frames].any():
        raise InputError(
            saw=f"no valid frame among the first {reference_frames}",
            expected="at least one, as displacement counts from there",
            remedy="use method='smooth', or more reference_frames if the object rested",
        )
    if mean_filter > 1:
        near = np.ones(mean_filter)
        counted = np.maximum(np.convolve(valid, near, "same"), 1)  # frames that are not valid have signal 0
        means = [np.asarray(np.convolve(column, near, "same") / counted, np.complex128) for column in signal.T]
        signal = np.stack(means, axis=1)
    resting = valid[:reference_frames]
    reference = signal[:reference_frames][resting].mean(axis=0)
    index = np.arange(len(valid))
    wrapped = reading.displacement_px(signal[valid], reference)
    if found.period_px is not None:
        wrapped = np.unwrap(wrapped, axis=0, period=found.period_px)
    displacement_px: Floats = np.stack([np.interp(index, index[valid], wrapped[:, axis]) for axis in range(2)], axis=1)

    variance = found.variance_px2(displacement_px + reading.displacement_px(reference, reading.origin))
    from_reference = variance[:reference_frames][resting].mean(axis=0) / max(mean_filter, np.count_nonzero(resting))
    sigma_px = np.sqrt(variance / mean_filter + from_reference)
    if reference_frames == 1:
        displacement_px = displacement_px - displacement_px[0]
        sigma_px[0] = 0.0
    return Trajectory(displacement_px, sigma_px, measurement.frame_time_s, "per-frame", valid)
