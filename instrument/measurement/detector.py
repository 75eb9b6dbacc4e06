"""The light that arrived, and its variance, from what the detector counted."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from instrument.config import DeadTimeKind
from instrument.recording import Recording
from protocols import Floats, InputError, Mask

_CHANCE = 6.0  # standard deviations above the largest mean count that chance may add
_LINEAR = 0.995  # of the largest mean count: above, a count no longer says how much light there was
_GAUSSIAN_MAD = 1.4826  # standard deviation of a normal distribution over its median absolute deviation


@dataclass(frozen=True)
class Detector:
    """A photon counter with dead time and dark counts."""

    picture_time_s: float
    """Time from one pattern to the next, for which each pattern is counted."""

    dead_time_s: float = 0.0
    """Dead time of detector and counter together."""

    dark_rate_hz: float = 0.0
    """Dark counts per second."""

    dead_time_kind: DeadTimeKind = "non-paralyzable"
    """What a photon does that comes in the dead time of another."""

    def light(self, counts: Floats) -> tuple[Floats, Floats]:
        """Correct counts for dead time and dark counts.

        A counter that is dead for tau after each count and counts n in the time T has missed some: the true number is
        N = n / (1 - n tau / T), from which the dark counts are subtracted. The variance of N is N / (1 - n tau / T), namely the
        variance of n, which dead time makes less than Poissonian, times (dN/dn)^2. It is computed from at least one count, so
        that an empty bin does not count as certain.

        Where a photon in the dead time prolongs it (paralyzable), N gives n = N exp(-N tau / T) counts. Of the two N that give n
        the smaller one is taken, N = -W(-n tau / T) T / tau with Lambert's W: counts rise with the light only up to T / (e tau).
        Their variance is n - n^2 (2 tau T - tau^2) / T^2.

        Args:
            counts: counts, of any shape; NaN stays NaN.

        Returns:
            Light in photons, and its variance in photons^2, both of the shape of ``counts``.

        Raises:
            InputError: there are more counts than the dead time allows.

        References:
            G. F. Knoll, "Radiation Detection and Measurement", chapter 4.
            J. W. Mueller, Nucl. Instrum. Methods 112 (1973) 47: variance of counts with dead time.
        """
        if self.dead_time_kind == "paralyzable" and self.dead_time_s > 0:
            return self._light_of_paralyzed(counts)
        dead_share = counts * (self.dead_time_s / self.picture_time_s)
        if np.nanmax(dead_share, initial=0.0) >= 1:
            raise InputError(
                saw=f"{float(np.nanmax(counts)):g} counts in a pattern of {self.picture_time_s * 1e6:g} us",
                expected=f"fewer than {self.picture_time_s / self.dead_time_s:g}, as the dead time is "
                f"{self.dead_time_s * 1e9:g} ns",
                remedy="check the counter's dead_time_s, or lower the light",
            )
        true_counts = counts / (1 - dead_share)
        return true_counts - self.dark_rate_hz * self.picture_time_s, np.maximum(true_counts, 1.0) / (1 - dead_share)

    def _light_of_paralyzed(self, counts: Floats) -> tuple[Floats, Floats]:
        """Correct counts of a paralyzable detector; as ``light``."""
        share = self.dead_time_s / self.picture_time_s
        most = 1 / (math.e * share)
        if np.nanmax(counts, initial=0.0) > most + _CHANCE * np.sqrt(most):
            raise InputError(
                saw=f"{float(np.nanmax(counts)):g} counts in a pattern of {self.picture_time_s * 1e6:g} us",
                expected=f"at most {most:g}, as a paralyzable detector with a dead time of {self.dead_time_s * 1e9:g} ns gives",
                remedy="check the counter's dead_time_s and dead_time_kind in [light], or lower the light",
            )
        below = np.minimum(counts, _LINEAR * most)
        true_counts = np.asarray(-lambert_w(-below * share) / share, np.float64)
        spread = np.maximum(below, 1.0) * np.maximum(1 - below * share * (2 - share), 0.05)
        slope = np.exp(-true_counts * share) * (1 - true_counts * share)
        return true_counts - self.dark_rate_hz * self.picture_time_s, spread / slope**2


def light_of(recording: Recording, light_weights: Floats) -> tuple[Floats, Floats]:
    """Give the light of every pattern of a recording, and its variance.

    Photon counts are corrected by ``Detector.light``. Values of other detectors are kept, and all have the variance that
    ``noise_variance`` estimates. The light of a background is found in the same way and subtracted; its variance is added.

    Args:
        recording: recording, with its background if there is one.
        light_weights: ``(patterns_per_frame,)`` weights of the total light, of the scheme.

    Returns:
        Values and variances, both ``(frames, patterns_per_frame)``, in the recording's unit and its square; NaN stays NaN.

    Raises:
        InputError: there are more counts than the dead time allows.
    """
    if not recording.photon_counts:
        light = recording.values if recording.background is None else recording.values - recording.background
        return light, np.full_like(light, noise_variance(light, light_weights, recording.frame_valid))
    detector = Detector(
        recording.picture_time_s, recording.dead_time_s, recording.dark_rate_hz, recording.light.dead_time_kind
    )
    light, variance = detector.light(recording.values)
    if recording.background is not None:
        background, background_variance = detector.light(recording.background)
        light, variance = light - background, variance + background_variance
    return light, variance


def noise_variance(values: Floats, light_weights: Floats, valid: Mask, brightness: Floats | None = None) -> float:
    """Estimate the variance of one value from the differences of the total light between successive frames.

    Their median absolute deviation is used, so that outliers do not count. A difference has twice the variance of the total
    light, whose variance is the sum of the squared weights times that of a value.

    Args:
        values: ``(frames, patterns_per_frame)``.
        light_weights: ``(patterns_per_frame,)`` weights of the values in the total light.
        valid: ``(frames,)`` whether the frame is used.
        brightness: ``(frames,)`` by what the values were divided, so that the noise of dark frames is enlarged; None for 1.

    Returns:
        The variance, before that division, in the squared unit of the values; infinite where there are fewer than three frames.
    """
    total = values[valid] @ light_weights
    known = np.isfinite(total)
    differences = np.diff(total[known])
    if brightness is not None:
        enlarged = brightness[valid][known] ** -2.0
        differences = differences / np.sqrt((enlarged[1:] + enlarged[:-1]) / 2)
    if len(differences) < 2:
        return float("inf")
    return float(_GAUSSIAN_MAD * np.median(np.abs(differences))) ** 2 / (2 * float(light_weights @ light_weights))


def lambert_w(x: Floats) -> Floats:
    """Give W(x), the principal branch of w exp(w) = x, for x from -1/e on."""
    from scipy import special  # noqa: PLC0415 - slow to load: only a paralyzable detector needs it

    branch: Any = special.lambertw
    return np.asarray(branch(x).real, np.float64)
