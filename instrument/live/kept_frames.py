"""The frames that a live image is made of: the newest one of each of the first Hadamard patterns."""

import numpy as np

from instrument.plan import Plan
from instrument.schemes import image_rows_of, scheme_of
from protocols import Floats, Integers


class KeptFrames:
    """Keeps one frame, the newest, of each of the first ``room`` Hadamard patterns in play order.

    A run that is longer than all patterns renews them when they come again. Frames of other patterns are not kept: the newest
    frames of a long run would be of fine patterns alone, and show nothing.

    Arrays begin with ``room``, one entry for each pattern; what stands where ``frame`` is -1 has no meaning.
    """

    def __init__(self, plan: Plan, room: int) -> None:
        """Prepare for a run of ``plan`` with ``room`` patterns, at most as many as the run shows."""
        self._cycle = min(plan.frames, plan.image_size**2)  # frames after which the patterns come again
        self.scheme = scheme_of(plan.model_copy(update={"frames": self._cycle}))
        rows = image_rows_of(self.scheme)
        columns = self.scheme.columns
        self._positive_after_middle_frames = columns[rows.positive].after_middle_frames
        self._negative_after_middle_frames = columns[rows.negative].after_middle_frames
        self.pairs: Integers = rows.pairs[:room].copy()
        """``(room, 2)``: Walsh rows of the pattern."""
        self.frame: Integers = np.full(room, -1)
        """``(room,)``: index of the newest frame; -1 where none has come yet."""
        self.values: Floats = np.zeros((room, len(columns)))
        """``(room, patterns_per_frame)``: values of that frame."""
        self.positive_px: Floats = np.zeros((room, 2))
        """``(room, 2)``: displacement x, y while H+ was shown."""
        self.negative_px: Floats = np.zeros((room, 2))
        """``(room, 2)``: displacement x, y while H- was shown."""
        self.seen = 0
        """Frames seen, those that were not kept included."""
        self._last_px = np.zeros((0, 2))  # displacement of the last two frames

    def __len__(self) -> int:
        """Give the number of frames kept."""
        return int(np.count_nonzero(self.frame >= 0))

    @property
    def nbytes(self) -> int:
        """Memory of the arrays, in bytes."""
        arrays = (self.pairs, self.frame, self.values, self.positive_px, self.negative_px)
        return sum(array.nbytes for array in arrays)

    def oldest_first(self) -> Integers:
        """Give the entries that hold a frame, in the order in which the frames came."""
        return np.argsort(self.frame)[len(self.frame) - len(self) :]

    def add(self, values: Floats, displacement_px: Floats) -> None:
        """Take the next frames, which are kept if they were measured and show one of the first patterns.

        Args:
            values: ``(n, patterns_per_frame)``, n at least 1; NaN where nothing was measured.
            displacement_px: ``(n, 2)`` x, y in the middle of each frame.
        """
        velocity_px = self._velocity_px(displacement_px)
        frame = self.seen + np.arange(len(values))
        self.seen += len(values)
        measured = np.isfinite(values).all(axis=1) & np.isfinite(displacement_px).all(axis=1)
        kept = np.flatnonzero(measured & (frame % self._cycle < len(self.frame)))
        entry = frame[kept] % self._cycle
        self.frame[entry] = frame[kept]
        self.values[entry] = values[kept]
        self.positive_px[entry] = displacement_px[kept] + self._positive_after_middle_frames * velocity_px[kept]
        self.negative_px[entry] = displacement_px[kept] + self._negative_after_middle_frames * velocity_px[kept]

    def _velocity_px(self, displacement_px: Floats) -> Floats:
        """Estimate the velocity in each frame, ``(n, 2)`` in px per frame.

        It is the smaller one of the last two steps, and 0 where their signs differ, so that a jump is not taken for a velocity.
        """
        path_px = np.concatenate([self._last_px, displacement_px])
        path_px = np.pad(path_px, ((2 - len(self._last_px), 0), (0, 0)), mode="edge")
        self._last_px = path_px[-2:].copy()
        steps_px = np.diff(path_px, axis=0)
        before, after = steps_px[:-1], steps_px[1:]
        smaller: Floats = np.where(np.abs(before) < np.abs(after), before, after)
        return np.where(before * after > 0, smaller, 0.0)
