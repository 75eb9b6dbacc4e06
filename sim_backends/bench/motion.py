"""Where the object is: carried by the stage, or along a trajectory from a file."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Protocol, TypeAlias

import numpy as np

from protocols import Floats

Position: TypeAlias = Callable[[Floats], Floats]
"""Clock seconds ``(n,)`` to stage position ``(n,)`` in mm."""

_DECIMALS = 6
"""Displacements are kept to a millionth of a pixel, so that the last bits of a clock reading, which differ from one
driver to the next, never reach a count."""


class Displacement(Protocol):
    """How far the object is from where it was drawn."""

    def at(self, start_s: float, time_s: Floats) -> Floats:
        """``(n, 2)``: x, y in px, ``time_s`` (n,) after the run's first sync edge, which came at ``start_s``."""
        ...


@dataclass(frozen=True, eq=False)
class Trajectory:
    """Displacement by linear interpolation between rows, held before the first and after the last."""

    row_time_s: Floats
    """``(rows,)`` times from the first sync edge, in seconds."""

    row_px: Floats
    """``(rows, 2)`` displacement along x and y, in image pixels."""

    def at(self, start_s: float, time_s: Floats) -> Floats:
        """See ``Displacement``; the start does not matter."""
        del start_s
        return np.stack([np.interp(time_s, self.row_time_s, self.row_px[:, axis]) for axis in (0, 1)], axis=1)


@dataclass(frozen=True, eq=False)
class StageMotion:
    """Displacement along the stage's axis, from where the stage says that it is."""

    carried: Sequence[tuple[float, Position]]
    """Since when (clock seconds, ascending), and the position from then on. What was said before a change stays true for
    the time before it, so that light may be worked out late. Before the first entry the stage stands at 0."""

    px_per_mm: float
    """Image scale, in image pixels a millimetre."""

    axis_angle_deg: float
    """Direction of positive stage motion: degrees from x (right) towards y (down)."""

    origin_mm: float
    """Stage position without displacement, in millimetres."""

    def at(self, start_s: float, time_s: Floats) -> Floats:
        """See ``Displacement``."""
        angle = math.radians(self.axis_angle_deg)
        axis = np.array([math.cos(angle), math.sin(angle)])
        way_mm = self.position_mm(start_s + time_s) - self.origin_mm
        at_px: Floats = np.round(way_mm[:, None] * self.px_per_mm * axis, _DECIMALS)
        return at_px

    def position_mm(self, clock_s: Floats) -> Floats:
        """``(n,)``: stage position at each clock time."""
        which = np.searchsorted([since_s for since_s, _ in self.carried], clock_s, side="right") - 1
        position_mm = np.zeros_like(clock_s)
        for index in np.unique(which[which >= 0]):
            here = which == index
            position_mm[here] = self.carried[int(index)][1](clock_s[here])
        return position_mm
