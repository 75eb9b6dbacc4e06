"""From what the detector counted to the light that came, and how sure that is."""

import numpy as np

from instrument.recording import Recording
from protocols import Floats, InputError

_GAUSSIAN_MAD = 1.4826  # standard deviation of a normal distribution over its median absolute deviation


def corrected_values(recording: Recording) -> tuple[Floats, Floats]:
    """Undo dead time and dark counts, and state the variance of every value.

    Photon counts: a counter that is dead for tau after each count and saw n counts in the time T missed some; there were
    N = n / (1 - n tau / T) (non-paralyzable; Knoll, "Radiation Detection and Measurement", chapter 4), of which dark counts
    are subtracted. The variance of N is N / (1 - n tau / T): that of n, which dead time makes less than Poisson, times the
    squared slope dN/dn. At least one count is assumed under it, so that an empty bin is no certainty.

    Other detectors: values stay as they are, with one variance for all, half of the noise of the total light
    I_H+ + I_H- between neighbouring frames (median absolute deviation, so outliers do not count). It is infinite where
    there are fewer than three frames to see it from.

    The light of a background is found in the same way and taken off; its variance is added.

    Args:
        recording: of the six-pattern scheme, or of another one whose last two patterns are complements.

    Returns:
        Values and variances, both ``(frames, patterns_per_frame)``, in the recording's unit and its square; NaN stays NaN.

    Raises:
        InputError: more counts than the dead time lets through.
    """
    if not recording.photon_counts:
        light = recording.values if recording.background is None else recording.values - recording.background
        return light, np.full_like(light, _noise_variance(light[recording.frame_valid]))
    light, variance = _photons(recording, recording.values)
    if recording.background is not None:
        behind, its_variance = _photons(recording, recording.background)
        light, variance = light - behind, variance + its_variance
    return light, variance


def _photons(recording: Recording, counts: Floats) -> tuple[Floats, Floats]:
    dead_share = counts * (recording.dead_time_s / recording.picture_time_s)
    if np.nanmax(dead_share, initial=0.0) >= 1:
        raise InputError(
            saw=f"{float(np.nanmax(counts)):g} counts in a pattern of {recording.picture_time_s * 1e6:g} us",
            expected=f"fewer than {recording.picture_time_s / recording.dead_time_s:g}, as the dead time is "
            f"{recording.dead_time_s * 1e9:g} ns",
            remedy="check the counter's dead_time_s, or lower the light",
        )
    came = counts / (1 - dead_share)
    return came - recording.dark_rate_hz * recording.picture_time_s, np.maximum(came, 1.0) / (1 - dead_share)


def _noise_variance(light: Floats) -> float:
    total = light[:, -2] + light[:, -1]
    steps = np.diff(total[np.isfinite(total)])
    if len(steps) < 2:
        return float("inf")
    return float(_GAUSSIAN_MAD * np.median(np.abs(steps))) ** 2 / 4
