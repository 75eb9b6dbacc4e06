"""Blocks of patterns into whole frames."""

from collections.abc import Iterator

import numpy as np

from instrument.acquisition import AlignedBlock
from protocols import Floats, InputError

_LOST_AT_ONCE = 4096  # frames: a long gap comes in pieces, so that it takes no more memory than a short one


class FrameAssembler:
    """Cuts a stream of blocks into frames, however the blocks are split. Keeps at most one frame that is not whole yet."""

    def __init__(self, patterns_per_frame: int, frames: int) -> None:
        """Prepare for a run of ``frames`` frames; patterns after the last of them are left out."""
        self._per_frame = patterns_per_frame
        self._end = patterns_per_frame * frames
        self._rest = np.zeros(0)
        self._next = 0  # pattern
        self._last_dropped = -1  # frame
        self._dropped = 0

    @property
    def frames_dropped(self) -> int:
        """Frames of which at least one pattern never came, as the block that held it was thrown away."""
        return self._dropped

    def whole(self, block: AlignedBlock) -> Iterator[Floats]:
        """Take the next block, and give the frames that are whole now.

        Yields:
            ``(n, patterns_per_frame)``, n may be 0: NaN for patterns that never came, or are not valid.

        Raises:
            InputError: a block that comes before the one that was taken last.
        """
        if block.first_pattern < self._next:
            raise InputError(
                saw=f"a block that starts at pattern {block.first_pattern}",
                expected=f"pattern {self._next} or a later one",
                remedy="pass the blocks on in the order in which the run gives them",
            )
        first = min(block.first_pattern, self._end)
        self._count_dropped(first)
        while self._next < first:
            yield self._cut(np.full(min(first - self._next, _LOST_AT_ONCE * self._per_frame), np.nan))
        yield self._cut(np.where(block.valid, block.values, np.nan)[: self._end - first])

    def _cut(self, values: Floats) -> Floats:
        self._next += len(values)
        stream = np.concatenate([self._rest, values])
        whole = len(stream) // self._per_frame * self._per_frame
        self._rest = stream[whole:].copy()
        return stream[:whole].reshape(-1, self._per_frame)

    def _count_dropped(self, until: int) -> None:
        if until > self._next:
            first = max(self._next // self._per_frame, self._last_dropped + 1)
            self._last_dropped = (until - 1) // self._per_frame
            self._dropped += self._last_dropped - first + 1
