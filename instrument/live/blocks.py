"""The one place where acquisition and live analysis meet: a bounded queue that never makes the acquisition wait."""

from collections import deque
from dataclasses import replace
from threading import Condition

from instrument.acquisition import AlignedBlock


class BlockQueue:
    """Keeps the newest blocks. Where they are too many, the oldest are dropped and counted."""

    def __init__(self, max_patterns: int) -> None:
        """Keep at most so many patterns, and at least the newest block."""
        self._max_patterns = max_patterns
        self._blocks: deque[AlignedBlock] = deque()
        self._patterns = 0
        self._dropped = 0
        self._closed = False
        self._changed = Condition()

    @property
    def patterns(self) -> int:
        """Patterns that wait."""
        return self._patterns

    @property
    def blocks_dropped(self) -> int:
        """Blocks thrown away so far."""
        return self._dropped

    def put(self, block: AlignedBlock) -> None:
        """Copy a block into the queue and return at once; into a closed one nothing goes any more."""
        copy = replace(block, values=block.values.copy(), valid=block.valid.copy(), edge_time_s=None)
        with self._changed:
            if self._closed:
                return
            self._blocks.append(copy)
            self._patterns += len(copy.values)
            while self._patterns > self._max_patterns and len(self._blocks) > 1:
                self._patterns -= len(self._blocks.popleft().values)
                self._dropped += 1
            self._changed.notify()

    def close(self, *, forget: bool = False) -> None:
        """Take no more blocks; with ``forget``, those that wait are thrown away too, uncounted."""
        with self._changed:
            self._closed = True
            if forget:
                self._blocks.clear()
                self._patterns = 0
            self._changed.notify()

    def take(self, *, wait: bool) -> list[AlignedBlock] | None:
        """All blocks that are there, oldest first.

        Args:
            wait: whether to wait for one; without, the list may be empty.

        Returns:
            None when the queue is closed and empty.
        """
        with self._changed:
            if wait:
                self._changed.wait_for(lambda: self._blocks or self._closed)
            if self._closed and not self._blocks:
                return None
            taken = list(self._blocks)
            self._blocks.clear()
            self._patterns = 0
            return taken
