"""Wiring: whether the modulator shows a pattern where its complement was meant, seen from the run itself.

Of the frame whose Hadamard pattern is all on, H+ has all the light there is and H- none. The other way round, either H- comes
before H+, or all mirrors are inverted, so that each value is that of the pattern's complement, S - I. Both give the same H+ and
H-. They are told apart by the position patterns: a fringe is much like a Walsh pattern, so that in frames of such Hadamard
patterns the difference H+ - H- goes with the fringe's own share of the light. If H+ and H- alone are exchanged it does so with
the wrong sign; if all is inverted both have the wrong sign, and it goes with the right one. Motion cannot tell them apart, as
an inverted fringe is one that is half a period away. Where there are no fringes, or no frames that tell, H- is taken to come
first.
"""

from typing import Final, Literal, TypeAlias

import numpy as np

from instrument.numerics import smooth
from instrument.patterns import hadamard_signs
from instrument.schemes import Scheme
from protocols import Floats, Integers

Wiring: TypeAlias = Literal["as planned", "H- first", "inverted"]

_DARK: Final = 0.25
"""Share of the light below which the pattern that is all on is dark, as far as noise allows to say."""

_FEWEST_FRAMES: Final = 8
"""Frames below which nothing is smoothed."""

_CERTAIN: Final = 5.0
"""Standard deviations."""

_ALIKE: Final = 0.5
"""Overlap from which on a fringe is much like a Walsh pattern."""


def wiring_of(light: Floats, variance: Floats, scheme: Scheme, image_size: int) -> tuple[Wiring, Integers, float]:
    """Find how the patterns are wired.

    Args:
        light: ``(frames, patterns_per_frame)``; NaN in frames that are not used.
        variance: ``(patterns_per_frame,)`` for noise that does not depend on the light; for photon counts all 0.
        scheme: what was meant to be shown.
        image_size: pixels a side.

    Returns:
        The wiring, the frames that show it, and H+ / S in them.
    """
    rows = scheme.image_rows
    nothing: tuple[Wiring, Integers, float] = ("as planned", np.zeros(0, np.int64), 1.0)
    if rows is None:
        return nothing
    pairs = rows.pairs[np.arange(len(light)) % len(rows.pairs)]
    columns = [rows.positive, rows.negative]
    all_on = (pairs == 0).all(axis=1) & ~rows.is_ramp(np.arange(len(light)))
    frames = np.flatnonzero(all_on & np.isfinite(light[:, columns]).all(axis=1))
    on, off = (float(light[frames, column].sum()) for column in columns)
    total = on + off
    noise = float(variance[columns].sum()) * len(frames) if variance.any() else max(total, 1.0)
    if not len(frames) or total <= 0 or on >= _DARK * total or off - on < _CERTAIN * noise**0.5:
        return nothing
    goes_with = _fringes_with_walsh(light, pairs, scheme, image_size)
    return "inverted" if goes_with < 0 else "H- first", frames, on / total


def rewired(values: Floats, wiring: Wiring, scheme: Scheme) -> Floats:
    """Give the values as they would be of patterns wired as planned: exchanged, or S - I.

    S is smoothed over frames. That of a frame has twice the noise of a value, and the differences three times the variance.
    """
    rows = scheme.image_rows
    if wiring == "as planned" or rows is None:
        return values
    mended = values.copy()
    columns = [rows.positive, rows.negative]
    mended[:, columns] = values[:, columns[::-1]]
    if wiring == "inverted":
        single = [k for k in range(values.shape[1]) if k not in columns]
        mended[:, single] = _steady(values[:, columns].sum(axis=1))[:, None] - values[:, single]
    return mended


def _steady(total: Floats) -> Floats:
    """Smooth the total light, ``(frames,)`` and NaN where it was not measured, as far as its data allow."""
    known = np.isfinite(total)
    if np.count_nonzero(known) < _FEWEST_FRAMES:
        return total
    smoothed = smooth(np.where(known, total, 0.0), known.astype(np.float64), orders=(1,)).values
    return np.where(known, smoothed, np.nan)


def _fringes_with_walsh(light: Floats, pairs: Integers, scheme: Scheme, image_size: int) -> float:
    """Sum of products of H+ - H-, exchanged, and the fringes' share of the light, where both patterns are much alike.

    Above 0 if the position patterns are as planned, below 0 if they are inverted.
    """
    rows = scheme.image_rows
    reading = scheme.position
    if rows is None or reading is None:
        return 0.0
    total = light[:, rows.positive] + light[:, rows.negative]
    difference = light[:, rows.negative] - light[:, rows.positive]
    single = [k for k in range(light.shape[1]) if k not in (rows.positive, rows.negative)]
    known = np.isfinite(light).all(axis=1)
    patterns = scheme.fixed_patterns
    size = patterns.shape[-1]
    finer = size // image_size
    score = 0.0
    for pattern, column in zip(patterns, single, strict=True):
        cells = 2.0 * pattern.reshape(image_size, finer, image_size, finer).mean(axis=(1, 3)) - 1
        for along, profile in ((1, cells.mean(axis=0)), (0, cells.mean(axis=1))):
            candidates = np.flatnonzero(known & (pairs[:, 1 - along] == 0) & (pairs[:, along] > 0))
            if not len(candidates):
                continue
            signs = hadamard_signs(image_size, pairs[candidates])
            lines = signs[:, 0, :] if along == 1 else signs[:, :, 0]
            overlap = lines @ profile / max(float(np.abs(profile).sum()), 1e-300)
            frames, alike = candidates[np.abs(overlap) > _ALIKE], overlap[np.abs(overlap) > _ALIKE]
            score += float(alike @ (difference[frames] * (2 * light[frames, column] - total[frames])))
    return score
