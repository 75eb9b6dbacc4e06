"""Displacement while the run goes on: causal, in constant memory, the same in any blocks.

Each phase series goes through a few fading-memory parabolas (constant acceleration), from nimble to calm. A frame's displacement
is the mean of their answers, weighted by each one's unbiased risk of late: mean squared residual + 2 * noise variance * gain.

References:
    Stein, Annals of Statistics 9 (1981) 1135-1151: unbiased risk.
"""

import numpy as np

from instrument.plan import Plan
from instrument.tracking.fading import FadingMean, FadingParabola
from protocols import Floats, InputError

_MEMORIES_FRAMES = (1.5, 4.0, 14.0, 50.0)
_TRUST_FRAMES = 60.0  # over which a filter is judged
_CLEAR_FRAMES = 4.0  # over which coefficients are averaged, only to count whole turns
_AHEAD_FRAMES = (1 / 3, 0.0)  # from the middle of an axis's two patterns to the middle of the frame
_TINY = 1e-12


class StreamingTracker:
    """Takes values as they come and gives displacements.

    ``push`` takes one frame or many; how the stream is cut makes no difference to the bit. A frame that was not measured (NaN,
    or no light) counts as a repetition of the one before; frames before the first good one have displacement 0.
    """

    def __init__(self, plan: Plan, *, total_memory_frames: float = 100.0) -> None:
        """Prepare for one run.

        Args:
            plan: what is shown.
            total_memory_frames: over how many frames the total light is averaged; 1 for a lamp that flickers faster.

        Raises:
            InputError: a memory below one frame.
        """
        if total_memory_frames < 1:
            raise InputError(saw=f"a memory of {total_memory_frames:g} frames", expected="1 or more", remedy="take 100")
        self._radians = 2 * np.pi * plan.frequency_per_px
        self._total = FadingMean(total_memory_frames, 1)
        self._clear = FadingMean(_CLEAR_FRAMES, 4)
        self._noise = FadingMean(_TRUST_FRAMES, 2)
        self._trust = FadingMean(_TRUST_FRAMES, 2 * len(_MEMORIES_FRAMES))
        self._filters = [FadingParabola(memory, _AHEAD_FRAMES) for memory in _MEMORIES_FRAMES]
        self._turns = np.zeros((2, 1))
        self._last_good: Floats | None = None
        self._last_angle: Floats | None = None
        self._last_places: Floats | None = None

    def push(self, values: Floats) -> Floats:
        """Take the next frames.

        Args:
            values: ``(n, 6)`` in play order; a stationary background is subtracted before.

        Returns:
            ``(n, 2)``: displacement in px in the middle of each frame, relative to frame 0, by what was known then.

        Raises:
            InputError: values of another shape.
        """
        if values.ndim != 2 or values.shape[1] != 6:
            raise InputError(
                saw=f"values of shape {values.shape}",
                expected="(n, 6)",
                remedy="push whole frames of the six-pattern scheme",
            )
        good = self._with_gaps_filled(values)
        displacement = np.zeros((len(values), 2))
        if len(good):
            series = np.ascontiguousarray(good.T)
            total = self._total.push(series[4:5] + series[5:6])
            displacement[len(values) - len(good) :] = self._follow(self._place(2 * series[:4] / total - 1)).T
        return displacement

    def _with_gaps_filled(self, values: Floats) -> Floats:
        """The frames from the first good one on, each bad one replaced by the good one before it."""
        lit = np.isfinite(values).all(axis=1) & (values[:, 4] + values[:, 5] > 0)
        good = values
        if not lit.all():
            latest = np.maximum.accumulate(np.where(lit, np.arange(len(values)), -1))
            if self._last_good is not None:
                values = np.vstack([values, self._last_good])  # which index -1 finds
            else:
                latest = latest[latest >= 0]
            good = values[latest]
        if len(good):
            self._last_good = good[-1].copy()
        return good

    def _place(self, parts: Floats) -> Floats:
        """-arg O~ in px, ``(2, n)``, unwrapped along the mean of recent coefficients."""
        mean = self._clear.push(parts)
        angle = np.arctan2(mean[1::2], mean[0::2])
        before = np.hstack([angle[:, :1] if self._last_angle is None else self._last_angle, angle[:, :-1]])
        turns = self._turns + np.cumsum(np.round((before - angle) / (2 * np.pi)), axis=1)
        self._last_angle, self._turns = angle[:, -1:], turns[:, -1:]
        cosine, sine = np.cos(angle), np.sin(angle)
        real, imaginary = parts[0::2], parts[1::2]
        aside = np.arctan2(imaginary * cosine - real * sine, real * cosine + imaginary * sine)
        return -(angle + 2 * np.pi * turns + aside) / self._radians

    def _noise_variance(self, place_px: Floats) -> Floats:
        """Of a phase, in px^2, ``(2, n)``: mean squared third difference, which motion hardly shows in, over 1 + 9 + 9 + 1."""
        last = np.repeat(place_px[:, :1], 3, axis=1) if self._last_places is None else self._last_places
        joined = np.hstack([last, place_px])
        self._last_places = joined[:, -3:]
        return self._noise.push(np.diff(joined, 3) ** 2 / 20) + _TINY

    def _follow(self, place_px: Floats) -> Floats:
        noise_px2 = self._noise_variance(place_px)
        answers, residuals, gains = zip(*(member.push(place_px) for member in self._filters), strict=True)
        squares = self._trust.push(np.vstack(residuals) ** 2)
        risks = [squares[2 * i : 2 * i + 2] / noise_px2 + 2 * gain for i, gain in enumerate(gains)]
        least = np.minimum.reduce(risks)
        answer, whole = np.zeros_like(least), np.zeros_like(least)
        for own, risk in zip(answers, risks, strict=True):
            weight = np.exp(-_TRUST_FRAMES / 2 * (risk - least))
            answer += weight * own
            whole += weight
        displacement: Floats = answer / whole
        return displacement
