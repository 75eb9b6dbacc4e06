"""Light that changes periodically, as lamps on the mains do: found in the total light of a run, and taken out of its values."""

from typing import Final

import numpy as np
from pydantic import NonNegativeFloat

from protocols import Floats, Frozen, Mask

_MOST: Final = 4
"""Lines that are looked for: 100 and 120 Hz, and an overtone of each."""

_LEAST_HZ: Final = 40.0
"""Frequency below which a change counts as drift."""

_FEWEST_PERIODS: Final = 8
"""Periods that a run must last for a line to be told from drift."""

_TREND_DEGREE: Final = 5
"""Degree of the polynomial that is taken off as drift."""

_BENDS: Final = 0.2
"""Ripple over the mean light from which on it bends the polynomial: both are then fitted again, each with the other taken off."""

_PASSES: Final = 6
"""Times at most that both are fitted: of a ripple of 0.98 over nine periods the first fit misses 0.03, the last one 0.001."""

_SIGNIFICANT: Final = 5.0
"""Amplitude, in its own standard deviations, from which on a line is taken: chance makes one in some 500 runs."""

_DARKEST: Final = 0.01
"""Brightness of a lamp over its mean that is taken at least: what is darker says nothing."""

_TELLS_APART: Final = 0.25
"""Standard deviation of the lamp's share above which all of a line is taken to be the lamp's."""


class Ripple(Frozen):
    """One line in the spectrum of the total light: amplitude times cos(2 pi f t - phase), over the mean."""

    frequency_hz: NonNegativeFloat
    """Frequency f."""

    amplitude: NonNegativeFloat
    """Amplitude over the mean total light."""

    phase_rad: float
    """Phase at the first edge of the run."""

    lamp_share: NonNegativeFloat = 1.0
    """Share of it that is the lamp's, 0 to 1. The rest is ambient light, which does not come by way of the object."""

    def at(self, time_s: Floats) -> Floats:
        """Give the ripple at times of any shape."""
        return np.asarray(self.amplitude * np.cos(2 * np.pi * self.frequency_hz * time_s - self.phase_rad), np.float64)


def without_ripples(values: Floats, time_s: Floats, ripples: tuple[Ripple, ...], mean_total: float) -> Floats:
    """Subtract ambient light that ripples, and divide by the lamp's ripple, each at the time of the pattern.

    Args:
        values: ``(frames, patterns_per_frame)`` light.
        time_s: likewise, middle of each pattern.
        ripples: what is to be taken out.
        mean_total: mean total light; a pattern has half of the total's ambient light, as the total is the sum of two patterns.

    Returns:
        Values of the same shape.
    """
    for ripple in ripples:
        ambient = (1 - ripple.lamp_share) * ripple.at(time_s) * mean_total / 2
        values = (values - ambient) / lamp_factor(time_s, (ripple,))
    return values


def lamp_factor(time_s: Floats, ripples: tuple[Ripple, ...]) -> Floats:
    """Brightness of a lamp that ripples over its mean, at times of any shape; never below a hundredth."""
    factor = np.ones(np.shape(time_s))
    for ripple in ripples:
        factor = factor * (1 + ripple.lamp_share * ripple.at(time_s))
    return np.maximum(factor, _DARKEST)


def ripples_seen(total: Floats, amplitude: Floats | None, valid: Mask, time_s: Floats) -> tuple[Ripple, ...]:
    """Find the lines in the total light of a run.

    The lamp's ripple changes the light of the object, and with it the amplitude of the position signals, in proportion; that of
    ambient light does not. The lamp's share is the slope of the regression of the one on the other.

    Args:
        total: ``(frames,)`` total light.
        amplitude: ``(frames, axes)`` amplitudes of the position signals, not divided by the total; None where there are none.
        valid: ``(frames,)`` whether it was measured.
        time_s: ``(frames,)`` when, evenly spaced.

    Returns:
        The lines found, the strongest first; none where the run is too short.
    """
    frames = len(total)
    if np.count_nonzero(valid) < max(64, frames // 2):
        return ()
    index = np.arange(frames)
    filled = np.interp(index, index[valid], total[valid])
    found: tuple[Ripple, ...] = ()
    rippled, trend = np.zeros(frames), np.zeros(frames)
    for _ in range(_PASSES):
        trend = _trend(filled - trend * rippled)
        if not (trend > 0).all():
            break
        found = _lines(filled / trend - 1, time_s)
        rippled = lamp_factor(time_s, found) - 1
        if rippled.max(initial=0.0) < _BENDS:
            break
    return tuple(line.model_copy(update={"lamp_share": _lamp_share(line, amplitude, valid, time_s)}) for line in found)


def _trend(total: Floats) -> Floats:
    """``(frames,)``: the polynomial that is taken off as drift."""
    place = np.linspace(-1, 1, len(total))
    fit = np.polynomial.chebyshev.chebfit(place, total, _TREND_DEGREE)
    return np.asarray(np.polynomial.chebyshev.chebval(place, fit), np.float64)


def _lines(left: Floats, time_s: Floats) -> tuple[Ripple, ...]:
    """Find the lines in relative changes of the total light, ``(frames,)``, the strongest first."""
    frames, step_s = len(left), float(time_s[1] - time_s[0])
    window = np.hanning(frames)
    frequency_hz = np.fft.rfftfreq(4 * frames, step_s)
    least_hz = max(_LEAST_HZ, _FEWEST_PERIODS / (frames * step_s))
    most_hz = (
        0.5 - _FEWEST_PERIODS / frames
    ) / step_s  # at half the frame rate amplitude and phase cannot be told apart
    among = (frequency_hz >= least_hz) & (frequency_hz <= most_hz)
    found: list[Ripple] = []
    for _ in range(_MOST):
        spectrum = np.abs(np.fft.rfft(left * window, 4 * frames)) * among
        near_hz = float(frequency_hz[int(np.argmax(spectrum))])
        ripple = _line(left, time_s, near_hz, 1 / (4 * frames * step_s))
        noise = float(np.std(left - ripple.at(time_s))) * np.sqrt(2 / frames)
        if not among.any() or ripple.amplitude < _SIGNIFICANT * noise:
            break
        left = left - ripple.at(time_s)
        found.append(ripple)
    return tuple(found)


def _line(series: Floats, time_s: Floats, near_hz: float, width_hz: float) -> Ripple:
    """Fit a cosine beside a constant to a series by least squares, its frequency near a given one."""
    from scipy.optimize import minimize_scalar  # noqa: PLC0415 - slow to load: not while a counter counts

    def fitted(frequency_hz: float) -> tuple[Floats, float]:
        angle = 2 * np.pi * frequency_hz * time_s
        design = np.stack([np.cos(angle), np.sin(angle), np.ones_like(angle)], axis=1)
        found: Floats = np.asarray(np.linalg.lstsq(design, series, rcond=None)[0], np.float64)
        return found, float(np.mean((series - design @ found) ** 2))

    bounds = (max(near_hz - width_hz, 0.0), near_hz + width_hz)
    best_hz = float(minimize_scalar(lambda hz: fitted(hz)[1], bounds=bounds, method="bounded").x)
    cosine, sine, _ = fitted(best_hz)[0].tolist()
    return Ripple(
        frequency_hz=best_hz, amplitude=float(np.hypot(cosine, sine)), phase_rad=float(np.arctan2(sine, cosine))
    )


def _lamp_share(ripple: Ripple, amplitude: Floats | None, valid: Mask, time_s: Floats) -> float:
    """Give the share of a line that the lamp has; 1 where the amplitudes do not say."""
    if amplitude is None:
        return 1.0
    seen = ripple.at(time_s)[valid]
    shares: list[float] = []
    variances: list[float] = []
    for series in amplitude[valid].T:
        relative = series / max(float(series.mean()), 1e-300) - 1
        shares.append(float(relative @ seen) / float(seen @ seen))
        variances.append(float(np.var(relative - shares[-1] * seen)) / float(seen @ seen))
    weights = 1 / np.maximum(variances, 1e-300)
    if not np.isfinite(weights).all() or weights.sum() ** -0.5 > _TELLS_APART:
        return 1.0
    return float(np.clip(np.average(shares, weights=weights), 0.0, 1.0))
