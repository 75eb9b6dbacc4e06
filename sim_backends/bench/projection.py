"""What a modulator tells the bench, and what a counter hears of it."""

from collections.abc import Callable
from dataclasses import dataclass

from protocols import Bytes, Floats, Integers


@dataclass(frozen=True, eq=False)
class Projection:
    """What a modulator is about to show."""

    start_s: float
    """Start of the first picture on the bench's clock."""

    picture_time_s: float
    """Time from the start of one picture to the start of the next, in seconds."""

    mirrors: Callable[[int], Bytes]
    """Unique plane index to ``(rows, columns / 8)`` packed mirrors, as ``PatternSequence.mirror_plane`` gives them."""

    play_order: Integers
    """``(pictures,)`` plane of each picture, the guard included."""

    sync_delay_s: float = 0.0
    """Time from a sync edge to the picture that it announces, in seconds."""

    silent: tuple[int, ...] = ()
    """Indices of the pictures that give no edge."""

    @property
    def first_edge_s(self) -> float:
        """When the first sync edge comes on a line without faults, on the bench's clock."""
        return self.start_s - self.sync_delay_s

    @property
    def duration_s(self) -> float:
        """From the start of the first picture to the end of the last."""
        return len(self.play_order) * self.picture_time_s


@dataclass(frozen=True, eq=False)
class Edges:
    """Sync edges as a counter sees them."""

    time_s: Floats
    """``(n,)`` times of the edges on the bench's clock, in seconds; not to be written."""

    first: int
    """Index of the first of them among all seen edges of the projection, from 0."""

    finished: bool
    """True when the projection is over and no edge will follow these. A stalled projection is never over."""

    def __len__(self) -> int:
        """Edges here."""
        return len(self.time_s)
