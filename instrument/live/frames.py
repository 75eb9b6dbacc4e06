"""Assembly of whole frames from blocks of patterns."""

from collections.abc import Iterator

import numpy as np

from instrument.acquisition import AlignedBlock
from protocols import Floats, InputError

_GAP_FRAMES = 4096  # frames of a gap that are given at once, so that a long gap takes no more memory than a short one


class FrameAssembler:
    """Cuts a stream of blocks into frames, wherever the blocks begin and end. It keeps at most one incomplete frame."""

    def __init__(self, patterns_per_frame: int) -> None:
        """Prepare for one run."""
        self._per_frame = patterns_per_frame
        self._rest = np.zeros(0)
        self._next = 0  # index of the next pattern
        self._last_dropped = -1  # index of the last frame counted as dropped
        self._dropped = 0

    @property
    def frames_dropped(self) -> int:
        """Number of frames of which at least one pattern never came, as the block that held it was discarded."""
        return self._dropped

    def whole(self, block: AlignedBlock) -> Iterator[Floats]:
        """Take the next block, and give the frames that it completes.

        Yields:
            Values, ``(n, patterns_per_frame)``, n at least 0; NaN for patterns that never came or are not valid.

        Raises:
            InputError: the block comes before the one that was taken last.
        """
        if block.first_pattern < self._next:
            raise InputError(
                saw=f"a block that starts at pattern {block.first_pattern}",
                expected=f"pattern {self._next} or a later one",
                remedy="pass the blocks on in the order in which the run gives them",
            )
        self._count_dropped(block.first_pattern)
        while self._next < block.first_pattern:
            yield self._cut(np.full(min(block.first_pattern - self._next, _GAP_FRAMES * self._per_frame), np.nan))
        yield self._cut(np.where(block.valid, block.values, np.nan))

    def _cut(self, values: Floats) -> Floats:
        """Append values to the incomplete frame, and give what is complete now."""
        self._next += len(values)
        stream = np.concatenate([self._rest, values])
        whole = len(stream) // self._per_frame * self._per_frame
        self._rest = stream[whole:].copy()
        return stream[:whole].reshape(-1, self._per_frame)

    def _count_dropped(self, until: int) -> None:
        """Count the frames of which patterns before ``until`` never came."""
        if until > self._next:
            first = max(self._next // self._per_frame, self._last_dropped + 1)
            self._last_dropped = (until - 1) // self._per_frame
            self._dropped += self._last_dropped - first + 1
