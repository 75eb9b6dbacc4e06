"""Phases of a stream of frames, unwrapped, as places: the measuring half of the streaming tracker."""

import numpy as np

from instrument.compiled import compiled
from protocols import Floats, Integers

_CLEAR_KEPT = 1 - 1 / 4.0  # a frame's share in the mean coefficient after another, by which whole turns are counted


class PhaseStream:
    """Takes values as they come and gives each axis's place by its phase alone."""

    def __init__(self, frequency_per_px: float, total_memory_frames: float) -> None:
        """Prepare.

        Args:
            frequency_per_px: of the fringes.
            total_memory_frames: over which the total light is averaged.
        """
        self._radians_per_px = 2 * np.pi * frequency_per_px
        self._light_kept = 1 - 1 / total_memory_frames
        self._frames = np.zeros(1, np.int64)
        self._good = np.zeros(6)
        self._light = np.zeros(2)
        self._clear = np.zeros((2, 2))
        self._turned = np.zeros((2, 2))

    def push(self, values: Floats) -> Floats:
        """Take the next frames, ``(n, 6)``.

        Returns:
            ``(k, 2)``: -arg O~ in px, along x and y, from the first good frame on: k is n from then on. A bad frame repeats the
            good one before it.
        """
        places_px = np.empty((len(values), 2))
        before = _places(
            np.ascontiguousarray(values, np.float64),
            (self._light_kept, self._radians_per_px),
            (self._good, self._light),
            (self._clear, self._turned),
            self._frames,
            places_px,
        )
        return places_px[before:]


@compiled("i8(f8[:, ::1], UniTuple(f8, 2), UniTuple(f8[::1], 2), UniTuple(f8[:, ::1], 2), i8[::1], f8[:, ::1])")
def _places(  # noqa: PLR0917
    values: Floats,
    constants: tuple[float, float],
    of_frame: tuple[Floats, Floats],
    of_axes: tuple[Floats, Floats],
    frames: Integers,
    places_px: Floats,
) -> int:
    """Write places, and give the number of frames before the first good one.

    ``of_frame``: values of the last good frame; fading sum of the light and of its weights. ``of_axes``: of each axis, fading
    sums of both parts of its coefficient; its last angle and whole turns.
    """
    light_kept, radians_per_px = constants
    good, light = of_frame
    clear, turned = of_axes
    before = 0
    for row in range(len(values)):
        lit = values[row, 4] + values[row, 5] > 0
        for k in range(6):
            lit = lit and np.isfinite(values[row, k])
        if lit:
            good[:] = values[row]
        elif frames[0] == 0:
            before += 1
            continue
        light[0] = light_kept * light[0] + good[4] + good[5]
        light[1] = light_kept * light[1] + 1
        for axis in range(2):
            real = 2 * good[2 * axis] * light[1] / light[0] - 1
            imaginary = 2 * good[2 * axis + 1] * light[1] / light[0] - 1
            clear[axis, 0] = _CLEAR_KEPT * clear[axis, 0] + real
            clear[axis, 1] = _CLEAR_KEPT * clear[axis, 1] + imaginary
            angle = np.arctan2(clear[axis, 1], clear[axis, 0])
            if frames[0] > 0:
                turned[axis, 1] += np.round((turned[axis, 0] - angle) / (2 * np.pi))
            turned[axis, 0] = angle
            cosine, sine = np.cos(angle), np.sin(angle)
            aside = np.arctan2(imaginary * cosine - real * sine, real * cosine + imaginary * sine)
            places_px[row, axis] = -(angle + 2 * np.pi * turned[axis, 1] + aside) / radians_per_px
        frames[0] += 1
    return before
