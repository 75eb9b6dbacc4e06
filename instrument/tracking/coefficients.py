"""The complex Fourier coefficients of a recording, as good as its light allows, and their steady unwrapping."""

from dataclasses import dataclass
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from instrument.light import corrected_values
from instrument.recording import Recording
from instrument.schemes import scheme_of
from instrument.tracking.smoothing import smooth
from protocols import Floats, InputError, Mask

Coefficients: TypeAlias = NDArray[np.complex128]
"""``(frames, 2)``: O~(f, 0), O~(0, f)."""

_DARK = 1e-12  # amplitude of an object that Fourier patterns do not see
_SIGNIFICANT = 5  # standard errors by which the mean light must stand above nothing
_FEWEST = 8  # frames from which anything can be smoothed
_CLEAR = 7.0  # amplitude over noise at which a phase no longer slips, frame after frame
_WINDOWS = (1, 3, 5, 9, 15, 25)


@dataclass(frozen=True, eq=False)
class Measured:
    """What tracking starts from."""

    coefficient: Coefficients
    """In units of the total light: of amplitude 1 for a point-like object. 0 where a frame is not valid."""

    valid: Mask
    """``(frames,)``: measured, finite, lit."""

    _total: Floats
    """``(frames,)``: the light behind each coefficient."""

    _variance: Floats
    """``(frames, 6)``: of the values, in units of light squared."""

    _counts: bool
    _smooth_total: bool

    def clarity(self) -> tuple[Floats, Floats]:
        """Mean amplitude of the coefficients, and standard deviation of its noise, both ``(2,)``.

        The amplitude does not know of motion, so its jumps between neighbouring frames are noise, and as much as the phase has.
        """
        amplitude = np.abs(self.coefficient)
        mean: Floats = np.maximum(amplitude[self.valid].mean(axis=0), _DARK)
        steps = np.diff(amplitude, axis=0)[self.valid[1:] & self.valid[:-1]]
        if len(steps) < _FEWEST:
            return mean, np.full(2, np.inf)
        return mean, np.sqrt((steps**2).mean(axis=0) / 2)

    def phase_variance(self, phase: Floats) -> Floats:
        """Variance of each frame's phase in rad^2, ``(frames, 2)``, were it ``phase``; infinite where nothing is known.

        Its pattern over the frames follows from the values' variances, 4 v_0 sin^2 + 4 v_90 cos^2 + (1 - sin 2 phase) v_S
        over the squared amplitude. Its size is what the amplitude shows.
        """
        if not np.isfinite(self._variance[self.valid]).all():
            return np.full_like(phase, np.inf)
        amplitude, deviation = self.clarity()
        sine, cosine = np.sin(phase), np.cos(phase)
        at_0, at_90 = self._variance[:, [0, 2]], self._variance[:, [1, 3]]
        if self._counts:
            # Of the counts expected: weighting by those that came would favour the low ones.
            unit = np.maximum(self._total, 1.0)[:, None] / 2
            at_0, at_90 = unit * (1 + amplitude * cosine), unit * (1 + amplitude * sine)
        of_total = 0.0 if self._smooth_total else (self._variance[:, 4] + self._variance[:, 5])[:, None]
        light = np.where(self.valid, self._total, np.nan)[:, None] ** 2
        across = (4 * at_0 * sine**2 + 4 * at_90 * cosine**2 + (1 - 2 * sine * cosine) * of_total) / light
        along = (4 * at_0 * cosine**2 + 4 * at_90 * sine**2 + (1 + 2 * sine * cosine) * of_total) / light
        size = np.ones(2)
        if np.isfinite(deviation).all() and np.nanmin(along) > 0:
            size = deviation**2 / np.nanmean(along, axis=0)
        return np.where(self.valid[:, None], across * size / amplitude**2, np.inf)


def measured(recording: Recording, *, smooth_total: bool) -> Measured:
    """Decode a recording frame by frame.

    Args:
        recording: of the six-pattern scheme.
        smooth_total: whether the total light, which enters every coefficient and does not change with motion, is smoothed over
            frames first: that takes a third of the coefficients' variance away.

    Raises:
        InputError: not one frame is both valid and lit.
    """
    values, variance = corrected_values(recording)
    total: Floats = values[:, 4] + values[:, 5]
    valid = recording.frame_valid & np.isfinite(values).all(axis=1)
    values = np.where(valid[:, None], values, 0.0)
    total = np.where(valid, total, 0.0)
    if smooth_total and np.count_nonzero(valid) >= _FEWEST:
        total = _steadied(values, total, valid)
    lit = valid & (total > 0)
    _expect_light(total[valid])
    if not lit.any():
        raise InputError(
            saw=f"no frame with light in a recording of {len(recording)} frames, {np.count_nonzero(valid)} of them valid",
            expected="frames with I_H+ + I_H- above 0",
            remedy="check light source, shutter and background, and the recording's timing report",
        )
    decoded = scheme_of(recording.plan).decode(values, total)
    coefficient = np.where(lit[:, None], decoded.coefficient / np.where(lit, total, 1.0)[:, None], 0.0)
    return Measured(coefficient, lit, total, variance, recording.photon_counts, smooth_total)


def _steadied(values: Floats, total: Floats, valid: Mask) -> Floats:
    """Total light without the noise of its measurement, but with the lamp's own flicker.

    What of a jump in the total is flicker shows in the Fourier values of the same frame, which add up to twice the total on
    the mean: the slope of their jumps on its jumps, halved, is flicker's share (linear regression on third differences).
    """
    steady = smooth(total, valid.astype(np.float64), orders=(1,)).values
    whole = np.convolve(~valid, np.ones(4), "valid") == 0
    jumps = np.diff(total, 3)[whole]
    answers = np.diff(values[:, :4].sum(axis=1), 3)[whole]
    power = float(jumps @ jumps)
    share = min(max(float(jumps @ answers) / (2 * power), 0.0), 1.0) if power > 0 else 0.0
    return steady + share * (total - steady)


def unwrapped(found: Measured) -> Floats:
    """Follow the phase from frame to frame without slips.

    Where a single frame is too noisy, the path is first followed on coefficients averaged over as many frames as make it clear,
    up to 25; each frame's own phase is then taken next to that path.

    Returns:
        ``(frames, 2)``: arg O~ in rad; frames that are not valid are bridged by lines.
    """
    index, valid = np.arange(len(found.valid)), found.valid
    _, deviation = found.clarity()
    phase = np.empty((len(valid), 2))
    for axis in range(2):
        series = found.coefficient[:, axis]
        mean = _clear_mean(series, valid, float(deviation[axis]))
        path = np.interp(index, index[valid], np.unwrap(np.angle(mean[valid])))
        phase[:, axis] = path + np.where(valid, np.angle(series * np.exp(-1j * path)), 0.0)
    return phase


def _clear_mean(series: NDArray[np.complex128], valid: Mask, deviation: float) -> NDArray[np.complex128]:
    """Average over the fewest frames that make phases clear; where none do (fast motion fades the mean), over the best number."""
    best, clearest = series, 0.0
    for window in _WINDOWS:
        if window > len(series) or not np.isfinite(deviation):
            break
        mean = np.convolve(series, np.ones(window), "same")
        clear = float(np.median(np.abs(mean[valid]))) / (deviation * np.sqrt(window) + 1e-300)
        if clear > clearest:
            best, clearest = mean, clear
        if clear >= _CLEAR:
            break
    return best


def _expect_light(total: Floats) -> None:
    """Refuse a run whose mean light could as well be the noise around none."""
    if len(total) < _FEWEST:
        return
    mean, error = float(np.mean(total)), float(np.std(total)) / np.sqrt(len(total))
    if mean < _SIGNIFICANT * error:
        raise InputError(
            saw=f"a mean light of {mean:.3g} with a standard error of {error:.2g}",
            expected="light well above the noise: an object to follow",
            remedy="check that the object is in the field, and light source and shutter",
        )
