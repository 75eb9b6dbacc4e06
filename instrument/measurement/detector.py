"""From what the detector counted to the light that came, and how sure that is."""

from dataclasses import dataclass

import numpy as np

from instrument.recording import Recording
from protocols import Floats, InputError, Mask

_GAUSSIAN_MAD = 1.4826  # standard deviation of a normal distribution over its median absolute deviation


@dataclass(frozen=True)
class Detector:
    """A photon counter with dead time and dark counts, and the time that it counted for each pattern."""

    picture_time_s: float
    """Time from one pattern to the next."""

    dead_time_s: float = 0.0
    """Non-paralyzable dead time of detector and counter."""

    dark_rate_hz: float = 0.0
    """Dark counts a second."""

    def light(self, counts: Floats) -> tuple[Floats, Floats]:
        """Undo dead time and dark counts.

        A counter that is dead for tau after each count and saw n counts in the time T missed some; there were
        N = n / (1 - n tau / T), of which dark counts are subtracted. The variance of N is N / (1 - n tau / T): that of n, which
        dead time makes less than Poisson, times the squared slope dN/dn. At least one count is assumed under it, so that an
        empty bin is no certainty.

        Args:
            counts: of any shape; NaN stays NaN.

        Returns:
            Light in photons, and its variance, both of the shape of ``counts``.

        Raises:
            InputError: more counts than the dead time lets through.

        References:
            Knoll, "Radiation Detection and Measurement", chapter 4.
        """
        dead_share = counts * (self.dead_time_s / self.picture_time_s)
        if np.nanmax(dead_share, initial=0.0) >= 1:
            raise InputError(
                saw=f"{float(np.nanmax(counts)):g} counts in a pattern of {self.picture_time_s * 1e6:g} us",
                expected=f"fewer than {self.picture_time_s / self.dead_time_s:g}, as the dead time is "
                f"{self.dead_time_s * 1e9:g} ns",
                remedy="check the counter's dead_time_s, or lower the light",
            )
        came = counts / (1 - dead_share)
        return came - self.dark_rate_hz * self.picture_time_s, np.maximum(came, 1.0) / (1 - dead_share)


def light_of(recording: Recording, light_weights: Floats) -> tuple[Floats, Floats]:
    """Give the light of every pattern of a recording, and its variance.

    Photon counts are corrected as ``Detector.light`` says. Values of other detectors stay as they are, with one variance for
    all: ``noise_variance``. The light of a background is found in the same way and taken off; its variance is added.

    Args:
        recording: what was measured.
        light_weights: of the scheme.

    Returns:
        Values and variances, both ``(frames, patterns_per_frame)``, in the recording's unit and its square; NaN stays NaN.

    Raises:
        InputError: more counts than the dead time lets through.
    """
    if not recording.photon_counts:
        light = recording.values if recording.background is None else recording.values - recording.background
        return light, np.full_like(light, noise_variance(light, light_weights, recording.frame_valid))
    detector = Detector(recording.picture_time_s, recording.dead_time_s, recording.dark_rate_hz)
    light, variance = detector.light(recording.values)
    if recording.background is not None:
        behind, its_variance = detector.light(recording.background)
        light, variance = light - behind, variance + its_variance
    return light, variance


def noise_variance(values: Floats, light_weights: Floats, valid: Mask) -> float:
    """Read the variance of one value off the jumps of the total light between neighbouring frames.

    The median absolute deviation of the jumps is used, so that outliers do not count. A jump has twice the variance of the
    total light, which has the sum of squared weights times that of a value.

    Args:
        values: ``(frames, patterns_per_frame)``.
        light_weights: ``(patterns_per_frame,)``: the total light is the sum of values times these.
        valid: ``(frames,)``.

    Returns:
        The variance; infinite where there are fewer than three frames to see it from.
    """
    total = values[valid] @ light_weights
    steps = np.diff(total[np.isfinite(total)])
    if len(steps) < 2:
        return float("inf")
    return float(_GAUSSIAN_MAD * np.median(np.abs(steps))) ** 2 / (2 * float(light_weights @ light_weights))
