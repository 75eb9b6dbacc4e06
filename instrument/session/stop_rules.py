"""``[stop_if]`` as a run goes on: looks at each block as it comes, and says when a rule has held for long enough."""

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Final

import numpy as np

from instrument.config import StopTable
from instrument.plan import Plan
from instrument.session.errors import RunStopped
from protocols import Floats, Mask

LIT_FRAMES: Final = 8
"""The brightest light so far is one that held for so many frames in a row: a wild count is no light."""

_DARK_SIGMAS: Final = 5.0
_DARK_COUNTS: Final = 2.0
"""A frame has no more than dark counts explain up to their mean, five standard deviations of it, and 2 counts, so that in a
run of a million dark frames about one is taken for a lit one."""


_ROUNDING: Final = 1e-9


@dataclass(frozen=True)
class Light:
    """What a bench has for too bright and for dark."""

    limit_hz: float
    """Highest count rate at which counts are linear."""

    dark_rate_hz: float
    """Dark counts a second."""


@dataclass
class _Rule:
    """One rule, and for how many frames it has held until now."""

    key: str
    """Its key in ``[stop_if]``."""

    hold_s: float
    """How long it must hold."""

    frames: int
    """Frames of that time."""

    saw: str
    """What every frame of the time has."""

    remedy: str
    """What to do."""

    holds_in: Callable[["_Frames"], Mask]
    """``(frames,)``: whether the rule holds in each."""

    held: int = 0

    def reached(self, found: Mask) -> int | None:
        """Take some frames; give the first of them with which the rule has held for long enough, None where none is."""
        index = np.arange(len(found))
        broken = np.maximum.accumulate(np.where(found, -1, index))
        lengths = np.where(broken < 0, self.held + index + 1, index - broken)
        self.held = int(lengths[-1])
        long_enough = np.flatnonzero(lengths >= self.frames)
        return int(long_enough[0]) if len(long_enough) else None


@dataclass(frozen=True, eq=False)
class _Frames:
    """Some whole frames."""

    values: Floats
    """``(frames, patterns)``, NaN where nothing was measured."""

    valid: Mask
    """As ``values``: whether the pattern was counted alone and whole."""

    photon_counts: bool
    """Whether values are photon counts."""


class StopRules:
    """Watches a run. It is asked in the run's own thread, and keeps a few numbers only."""

    def __init__(self, plan: Plan, light: Light) -> None:
        """Watch by the plan's ``[stop_if]``, which may be missing."""
        table = plan.stop_if
        self._patterns = plan.patterns_per_frame
        self._picture_time_s = plan.picture_time_s
        self._light = light
        self._below = 0.0 if table is None else table.light_below
        self._brightest = 0.0
        self._latest: Floats = np.zeros(0)
        self._open_values: Floats = np.zeros(0)
        self._open_valid: Mask = np.zeros(0, np.bool_)
        self._frames = 0
        self._rules = [] if table is None else self._of(table, plan.frame_time_s)

    def _of(self, table: StopTable, frame_time_s: float) -> list[_Rule]:
        limit_hz, holds = self._light.limit_hz, table.rules
        known = (
            (
                "too_bright_s",
                f"a pattern above the counter's linear limit of {limit_hz:.3g} counts/s in each of them",
                "dim the light, or put in a denser filter",
                self._too_bright,
            ),
            (
                "light_gone_s",
                f"less than {table.light_below:g} of the brightest light so far, or dark counts alone, in each of them",
                "look at the lamp, the shutter, and whether the object is in the field",
                self._light_gone,
            ),
            (
                "audit_fails_s",
                "a sync edge that is missing, doubled or irregular in each of them",
                "look at the sync cable and its termination",
                self._audit_fails,
            ),
        )
        return [
            _Rule(key, holds[key], max(1, math.ceil(holds[key] / frame_time_s - _ROUNDING)), saw, remedy, holds_in)
            for key, saw, remedy, holds_in in known
            if key in holds
        ]

    def see(self, values: Floats, valid: Mask, *, photon_counts: bool) -> RunStopped | None:
        """Take the next patterns in play order; give what ends the run, None where it goes on.

        Args:
            values: ``(n,)``; NaN where nothing was measured.
            valid: ``(n,)``: whether the pattern was counted alone and whole.
            photon_counts: whether values are photon counts.
        """
        if not self._rules:
            return None
        values, valid = np.concatenate([self._open_values, values]), np.concatenate([self._open_valid, valid])
        whole = len(values) // self._patterns
        cut = whole * self._patterns
        self._open_values, self._open_valid = values[cut:], valid[cut:]
        if not whole:
            return None
        shape = (whole, self._patterns)
        frames = _Frames(values[:cut].reshape(shape), valid[:cut].reshape(shape), photon_counts)
        first, self._frames = self._frames, self._frames + whole
        reached = [(frame, rule) for rule in self._rules if (frame := rule.reached(rule.holds_in(frames))) is not None]
        if not reached:
            return None
        frame, rule = min(reached, key=lambda at: at[0])
        end = first + frame + 1
        return RunStopped(
            rule=rule.key,
            hold_s=rule.hold_s,
            frames=(end - rule.frames, end),
            pattern=end * self._patterns,
            found=rule.saw,
            remedy=rule.remedy,
        )

    def _too_bright(self, frames: _Frames) -> Mask:
        if not frames.photon_counts:
            return np.zeros(len(frames.values), np.bool_)
        limit = self._light.limit_hz * self._picture_time_s * (1 + _ROUNDING)
        return np.asarray((np.where(frames.valid, frames.values, 0) > limit).any(axis=1))

    def _light_gone(self, frames: _Frames) -> Mask:
        """Judge the mean value of each frame, over the patterns that were measured; a frame without any is not judged."""
        measured = frames.valid & np.isfinite(frames.values)
        counted = measured.sum(axis=1)
        mean = np.where(measured, frames.values, 0).sum(axis=1) / np.maximum(counted, 1)
        dark = self._light.dark_rate_hz * self._picture_time_s if frames.photon_counts else 0.0
        light = np.where(counted > 0, mean - dark, np.nan)
        brightest = self._brightest_until(light)
        gone = np.asarray((light < self._below * brightest) & (brightest > 0))
        if frames.photon_counts:
            expected = dark * counted
            gone |= mean * counted <= expected + _DARK_SIGMAS * np.sqrt(expected) + _DARK_COUNTS
        return np.asarray(gone & (counted > 0))

    def _brightest_until(self, light: Floats) -> Floats:
        """``(frames,)``: the brightest light that held for ``LIT_FRAMES`` frames, up to each frame."""
        known = np.concatenate([self._latest, light])
        self._latest = known[-(LIT_FRAMES - 1) :]
        brightest = np.full(len(known), self._brightest)
        if len(known) >= LIT_FRAMES:
            windows = np.lib.stride_tricks.sliding_window_view(known, LIT_FRAMES)
            held = np.nan_to_num(windows.min(axis=1), nan=0.0)
            brightest[LIT_FRAMES - 1 :] = np.maximum(brightest[LIT_FRAMES - 1 :], np.maximum.accumulate(held))
        self._brightest = float(brightest[-1])
        return brightest[len(known) - len(light) :]

    def _audit_fails(self, frames: _Frames) -> Mask:
        return np.asarray(~frames.valid.all(axis=1))
