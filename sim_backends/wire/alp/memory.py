"""The board's picture memory: one contiguous block a sequence (dlp7000.md 2.1)."""


class FrameMemory:
    """First-fit allocation in binary frames."""

    def __init__(self, frames: int) -> None:
        """Begin with ``frames`` free binary frames in one piece."""
        self.frames = frames
        self._blocks: dict[int, int] = {}

    def _gaps(self) -> list[tuple[int, int]]:
        """Start and length of every free stretch, in order."""
        gaps: list[tuple[int, int]] = []
        start = 0
        for block in sorted(self._blocks):
            gaps.append((start, block - start))
            start = block + self._blocks[block]
        return [*gaps, (start, self.frames - start)]

    @property
    def largest_gap(self) -> int:
        """Longest contiguous free stretch: what ALP_AVAIL_MEMORY tells."""
        return max(length for _, length in self._gaps())

    def allocate(self, frames: int) -> int | None:
        """Take ``frames`` frames and give their first address, or None where no gap is long enough."""
        for start, length in self._gaps():
            if length >= frames:
                self._blocks[start] = frames
                return start
        return None

    def release(self, start: int) -> None:
        """Give back the block that ``allocate`` placed at ``start``."""
        del self._blocks[start]
