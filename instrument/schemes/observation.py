"""What the light of each frame says of the object's position, and how surely."""

from dataclasses import dataclass

import numpy as np

from instrument.schemes.reading import PositionReading, Signals, as_signals
from protocols import Floats, Mask

_NO_AMPLITUDE = 1e-12  # amplitude of an object that Fourier patterns do not see
_FEWEST = 8  # frames from which the noise of an amplitude can be told


@dataclass(frozen=True, eq=False)
class Light:
    """Light of every pattern, as an observation of position needs it."""

    values: Floats
    """``(frames, patterns_per_frame)``: light; anything where a frame is not valid."""

    variance: Floats
    """Likewise: variance of the values."""

    total: Floats
    """``(frames,)``: total light S of each frame."""

    total_variance: Floats
    """``(frames,)``: variance of ``total``; 0 where it is smoothed over many frames."""

    valid: Mask
    """``(frames,)``: whether every value of the frame was measured, and there is light."""

    photon_counts: bool
    """Whether the values are photons, whose variance follows from what is expected."""


@dataclass(frozen=True, eq=False)
class Observation:
    """One position a frame and axis: its signal, its variance, and the period within which it is unambiguous."""

    reading: PositionReading
    """How values become positions."""

    light: Light
    """Where the signal comes from."""

    signal: Signals
    """``(frames, 2)``: along x and y; 0 where a frame is not valid."""

    @classmethod
    def of(cls, reading: PositionReading, light: Light, centre: Signals | None = None) -> "Observation":
        """Read the position out of the light of each frame.

        Args:
            reading: how values become positions.
            light: light of every pattern.
            centre: ``(2,)`` part of the signals along x and y that does not stem from the object; None for 0.
        """
        valid = light.valid
        total = np.where(valid, light.total, 1.0)
        signal = reading.signal(np.where(valid[:, None], light.values, 0.0), total)
        if centre is not None:
            signal = signal - centre
        return cls(reading, light, np.where(valid[:, None], signal, 0.0))

    @property
    def valid(self) -> Mask:
        """``(frames,)``: whether the frame was measured."""
        return self.light.valid

    @property
    def period_px(self) -> float | None:
        """Displacement after which the observation repeats; None where it is unambiguous."""
        return self.reading.period_px

    def amplitude(self) -> tuple[Floats, Floats]:
        """Mean amplitude of a periodic signal, and standard deviation of its noise, both ``(2,)``.

        The amplitude does not know of motion, so its jumps between neighbouring frames are noise, and as much as the phase has.
        """
        amplitude = np.abs(self.signal)
        mean: Floats = np.maximum(amplitude[self.valid].mean(axis=0), _NO_AMPLITUDE)
        steps = np.diff(amplitude, axis=0)[self.valid[1:] & self.valid[:-1]]
        if len(steps) < _FEWEST:
            return mean, np.full(2, np.inf)
        return mean, np.sqrt((steps**2).mean(axis=0) / 2)

    def variance_px2(self, place_px: Floats) -> Floats:
        """Variance of each frame's position, ``(frames, 2)``, were it ``place_px``; infinite where nothing is known.

        How it varies over the frames follows from the values' variances. Its size is, for a periodic signal, what the noise of
        the amplitude shows.
        """
        if not np.isfinite(self.light.variance[self.valid]).all():
            return np.full_like(place_px, np.inf)
        if self.period_px is None:
            covariance = self._covariance(place_px, np.ones(2))
            return np.where(self.valid[:, None], covariance[..., 0, 0], np.inf)
        amplitude, deviation = self.amplitude()
        covariance = self._covariance(place_px, amplitude)
        along = self.reading.direction(place_px)
        across = along[..., ::-1] * [-1.0, 1.0]
        radial = np.einsum("fap,fapq,faq->fa", along, covariance, along)
        angular = np.einsum("fap,fapq,faq->fa", across, covariance, across)
        size = np.ones(2)
        if np.isfinite(deviation).all() and np.nanmin(radial[self.valid]) > 0:
            size = deviation**2 / radial[self.valid].mean(axis=0)
        per_radian_px = self.period_px / (2 * np.pi)
        return np.where(self.valid[:, None], angular * size / amplitude**2 * per_radian_px**2, np.inf)

    def _covariance(self, place_px: Floats, amplitude: Floats) -> Floats:
        """``(frames, 2, parts, parts)``: covariance of the signal's parts, were the object at ``place_px``."""
        reading, light = self.reading, self.light
        expected = self.reading.direction(place_px) * amplitude[:, None]
        variance = light.variance[:, reading.columns]
        if light.photon_counts:
            # Of the counts expected: weighting by those that came would favour the low ones.
            variance = np.maximum(light.total, 1.0)[:, None, None] * np.maximum(reading.shares(expected), 0.0)
        by_total = expected - reading.offset  # minus the derivative of the signal by S, times S
        covariance = np.einsum("apk,aqk,fak->fapq", reading.weights, reading.weights, variance)
        covariance += np.einsum("fap,faq,f->fapq", by_total, by_total, light.total_variance)
        scale = np.where(self.valid, light.total, np.nan)[:, None, None, None] ** 2
        return np.asarray(covariance / scale, np.float64)

    def expected_direction(self, path_px: Floats) -> Signals:
        """``(frames, 2)``: signal of amplitude 1 that would be measured on a path, each pattern at its own time.

        Args:
            path_px: ``(frames, 2)`` position in the middle of each frame.
        """
        velocity = np.gradient(path_px, axis=0)
        acceleration = np.gradient(velocity, axis=0)
        after = self.reading.after_middle_frames
        places = path_px[..., None] + velocity[..., None] * after + acceleration[..., None] * (after**2 / 2)
        shares = np.einsum("akp,fakp->fak", self.reading.response, self.reading.direction(places))
        return as_signals(np.einsum("apk,fak->fap", self.reading.weights, shares))

    def in_mid_frame_px(self, path_px: Floats) -> Floats:
        """``(frames, 2)``: position in the middle of each frame, as its patterns saw it at their own times on about this path."""
        aside = self.reading.displacement_px(self.signal, self.expected_direction(path_px))
        return path_px + np.where(self.valid[:, None], aside, 0.0)

    def amplitude_px(self, path_px: Floats) -> Floats | None:
        """``(frames, 2)``: amplitude over its mean, in the unit of position: it has the same noise, and no motion in it.

        None where the signal has no amplitude, as that of a moment.
        """
        if self.period_px is None:
            return None
        mean, _ = self.amplitude()
        seen = (self.signal * np.conj(self.expected_direction(path_px))).real / mean
        return np.asarray(seen * (self.period_px / (2 * np.pi)), np.float64)
