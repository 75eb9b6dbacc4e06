"""Displacement while the run goes on: causal, in constant memory, and independent of how the stream is cut into blocks."""

import numpy as np

from instrument.plan import Plan
from instrument.schemes import position_of, scheme_of
from instrument.tracking.filter_bank import FilterBank
from instrument.tracking.place_stream import PlaceStream
from protocols import Floats, InputError


class StreamingTracker:
    """Takes values as they come and gives displacements.

    ``push`` takes one frame or many; the results are the same to the bit. A frame that was not measured (NaN, or no light)
    counts as a repetition of the one before. Frames before the first good one have the displacement 0.
    """

    def __init__(self, plan: Plan, *, total_memory_frames: float = 100.0) -> None:
        """Prepare for one run.

        Args:
            plan: plan of the run.
            total_memory_frames: number of frames over which the total light is averaged; 1 for a lamp that flickers faster.

        Raises:
            InputError: the memory is below one frame, or the scheme has no position.
        """
        if total_memory_frames < 1:
            raise InputError(saw=f"a memory of {total_memory_frames:g} frames", expected="1 or more", remedy="take 100")
        scheme = scheme_of(plan)
        self._patterns = len(scheme.columns)
        self._places = PlaceStream(scheme, total_memory_frames)
        # The displacement is wanted in the middle of the frame, and measured in the middle of an axis's patterns.
        x_delay_frames, y_delay_frames = (-position_of(scheme).after_middle_frames.mean(axis=1)).tolist()
        self._bank = FilterBank((x_delay_frames, y_delay_frames))
        self.sigma_px: Floats = np.zeros((0, 2))
        """``(n, 2)`` standard uncertainty of the displacements that ``push`` gave last, from the scatter of the positions around
        their path; NaN where it is not known: in the first frames, and before the first good one."""

    def push(self, values: Floats) -> Floats:
        """Take the next frames.

        Args:
            values: ``(n, patterns_per_frame)`` in play order, after subtraction of a stationary background.

        Returns:
            ``(n, 2)`` displacement in px, x and y, in the middle of each frame relative to frame 0, from what was known then.

        Raises:
            InputError: the values have another shape.
        """
        if values.ndim != 2 or values.shape[1] != self._patterns:
            raise InputError(
                saw=f"values of shape {values.shape}",
                expected=f"(n, {self._patterns})",
                remedy="push whole frames of the plan's scheme",
            )
        displacement_px, self.sigma_px = np.zeros((len(values), 2)), np.full((len(values), 2), np.nan)
        places_px = self._places.push(values)
        known = slice(len(values) - len(places_px), None)
        displacement_px[known] = self._bank.push(places_px)
        self.sigma_px[known] = self._bank.sigma_px
        return displacement_px
