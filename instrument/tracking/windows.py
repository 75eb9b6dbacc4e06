"""The path of a run that is too long to be looked at as a whole: tracked window by window, and joined where windows overlap.

In frames that two windows share both have seen the same values. Their paths there differ by a constant, as each is relative to
its own first frame, and by next to nothing else. So what is joined is as true to the positions of the patterns as each part, and
errors do not add up from window to window.
"""

from dataclasses import dataclass

import numpy as np

from instrument.tracking.trajectory import Trajectory
from protocols import Floats, InputError, Mask


@dataclass(frozen=True)
class Window:
    """Successive frames of a run."""

    first: int
    """First frame."""

    end: int
    """Frame after the last one."""

    own: int
    """Frame from which on this window counts: those before are shared with the window before, and join both."""


def windows_of(frames: int, length: int, cycle: int) -> list[Window]:
    """Cut a run into windows that overlap by one cycle of its patterns, and begin where the patterns do.

    Args:
        frames: of the run.
        length: frames of a window that count, at least; rounded up to whole cycles.
        cycle: frames after which patterns repeat.

    Returns:
        The windows. The last one takes what is left of less than a cycle.

    Raises:
        InputError: a length below 1.
    """
    if length < 1:
        raise InputError(saw=f"windows of {length} frames", expected="1 or more", remedy="ask for longer windows")
    length = -(-length // cycle) * cycle
    starts = list(range(0, max(1, frames - cycle + 1), length))
    ends = [*starts[1:], frames]
    return [Window(max(0, own - cycle), end, own) for own, end in zip(starts, ends, strict=True)]


class JoinedPath:
    """The path of a run, made of the paths of its windows as they come."""

    def __init__(self, frames: int) -> None:
        """Nothing is known yet.

        Args:
            frames: of the run.
        """
        self._place_px: Floats = np.full((frames, 2), np.nan)
        self._sigma_px: Floats = np.full((frames, 2), np.nan)
        self._valid: Mask = np.zeros(frames, np.bool_)
        self._method = "smooth"

    def add(self, window: Window, path: Trajectory) -> Floats:
        """Take the path of the next window.

        Args:
            window: frames of the window.
            path: of these frames, relative to the first of them.

        Returns:
            ``(2,)`` displacement of that first frame relative to frame 0 of the run.
        """
        shared = window.own - window.first
        start = np.zeros(2)
        if shared:
            inside = slice(shared // 4, shared - shared // 4)  # an end of a window is known less well
            before = self._place_px[window.first : window.own][inside]
            start = np.asarray((before - path.displacement_px[:shared][inside]).mean(axis=0), np.float64)
        own = slice(shared // 2, None)
        there = slice(window.first + shared // 2, window.end)
        self._place_px[there] = path.displacement_px[own] + start
        self._sigma_px[there] = path.sigma_px[own]
        self._valid[there] = path.valid[own]
        self._method = path.method
        return start

    def trajectory(self, frame_time_s: float) -> Trajectory:
        """Give the path, relative to frame 0.

        Its uncertainty is that of each window, of a place relative to an end that is known as well as frame 0 is.
        """
        return Trajectory(self._place_px - self._place_px[0], self._sigma_px, frame_time_s, self._method, self._valid)
