"""Displacement while the run goes on: causal, in constant memory, the same in any blocks."""

import numpy as np

from instrument.plan import Plan
from instrument.schemes import position_of, scheme_of
from instrument.tracking.filter_bank import FilterBank
from instrument.tracking.place_stream import PlaceStream
from protocols import Floats, InputError


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
            InputError: a memory below one frame, or a scheme without position.
        """
        if total_memory_frames < 1:
            raise InputError(saw=f"a memory of {total_memory_frames:g} frames", expected="1 or more", remedy="take 100")
        scheme = scheme_of(plan)
        self._patterns = len(scheme.columns)
        self._places = PlaceStream(scheme, total_memory_frames)
        # From the middle of an axis's patterns to the middle of the frame.
        x_frames, y_frames = (-position_of(scheme).after_middle_frames.mean(axis=1)).tolist()
        self._bank = FilterBank((x_frames, y_frames))

    def push(self, values: Floats) -> Floats:
        """Take the next frames.

        Args:
            values: ``(n, patterns_per_frame)`` in play order; a stationary background is subtracted before.

        Returns:
            ``(n, 2)``: displacement in px in the middle of each frame, relative to frame 0, by what was known then.

        Raises:
            InputError: values of another shape.
        """
        if values.ndim != 2 or values.shape[1] != self._patterns:
            raise InputError(
                saw=f"values of shape {values.shape}",
                expected=f"(n, {self._patterns})",
                remedy="push whole frames of the plan's scheme",
            )
        displacement_px = np.zeros((len(values), 2))
        places_px = self._places.push(values)
        displacement_px[len(values) - len(places_px) :] = self._bank.push(places_px)
        return displacement_px
