"""What the position values of a run say against each other, and where they hardly say anything."""

from typing import Final

import numpy as np

from instrument.measurement import Measurement

_APART: Final = 0.1
"""Difference of the light that the patterns of both axes see, over that light, above which they contradict each other. Mirrors
that leak an eighth of the picture before, or lose a tenth at their edges, made up to 0.09; values that slipped 0.12 or more."""

_SIGMAS: Final = 4.0
"""Standard deviations that this difference may have by chance."""

_BLOCKS: Final = 8
"""Parts of a run in each of which it is looked at."""

_WEAK: Final = 0.2
"""Amplitude of the fringes' signal over the light below which a place may be wrong by more than its noise says. Fine bars have
0.3, letters of half a fringe 0.5 and more."""


_WEAK_WITH_IMAGE: Final = 0.1
"""The same where an image was found together with the path: it knows what fine bars do to the light of the fringes."""


def position_doubts(measurement: Measurement, *, with_image: bool, beside_background: bool) -> tuple[str, ...]:
    """Say where the position values contradict each other, and where they are weak.

    Args:
        measurement: the light.
        with_image: whether an image was found together with the path.
        beside_background: whether light of something that stands still was found beside the object: it makes signals weaker.
    """
    return (
        *_of_both_axes(measurement),
        *(() if beside_background else _of_signals(measurement, with_image=with_image)),
    )


def _of_both_axes(measurement: Measurement) -> tuple[str, ...]:
    """Say that the patterns along x and those along y do not see the same light, where those of each axis tell it."""
    position = measurement.scheme.position
    weights = None if position is None else position.light_weights
    frames = np.flatnonzero(measurement.valid)
    if position is None or weights is None or not len(frames):
        return ()
    apart = 0.0
    for part in np.array_split(frames, min(_BLOCKS, len(frames))):
        x, y = (measurement.values[part][:, of] @ by for of, by in zip(position.columns, weights, strict=True))
        of_axes = zip(position.columns, weights, strict=True)
        variance = sum(float((measurement.variance[part][:, of] @ by**2).sum()) for of, by in of_axes)
        difference, light = abs(float((x - y).sum())), float((x + y).sum()) / 2
        chance = _SIGMAS * measurement.student_ratio * variance**0.5
        if light > 0 and difference > max(_APART * light, chance):
            apart = max(apart, difference / light)
    if not apart:
        return ()
    why = (
        f"the patterns along x and those along y see light that differs by up to {100 * apart:.0f} %, though both let all of it "
        "through: values slipped to other patterns, or patterns are wired otherwise than planned, and the path cannot be "
        "trusted; look at the sync line, and at the order of the patterns"
    )
    return (why,)


def _of_signals(measurement: Measurement, *, with_image: bool) -> tuple[str, ...]:
    """Say along which axis the object is so long, or so finely divided, that the light of the fringes hardly changes."""
    position = measurement.scheme.position
    if position is None or position.period_px is None:
        return ()
    found = measurement.observe(steady=True)
    _, noise = found.amplitude()
    if not np.isfinite(noise).all():
        return ()
    squares = (np.abs(found.signal[found.valid]) ** 2).mean(axis=0) - 2 * noise**2
    return tuple(
        f"only {100 * part:.0f} % of the light goes up and down with the fringes along {axis}: the object is about as long as a "
        f"fringe, or much of the light is not its own, so that its place along {axis} may be wrong by more than is stated; fewer "
        "fourier_cycles suit larger objects"
        for axis, part in zip("xy", np.sqrt(np.maximum(squares, 0.0)).tolist(), strict=True)
        if part < (_WEAK_WITH_IMAGE if with_image else _WEAK)
    )
