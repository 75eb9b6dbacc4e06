"""The patterns of one frame, each a column of the values."""

from typing import Literal, TypeAlias

from protocols import Frozen

Role: TypeAlias = Literal["fourier", "moment", "hadamard", "picture"]
Axis: TypeAlias = Literal["x", "y"]


class Column(Frozen):
    """One pattern of a frame: a column of the values."""

    role: Role
    """Kind of pattern."""

    axis: Axis | None = None
    """Axis whose position the pattern measures; None where it measures none."""

    phase_rad: float = 0.0
    """Phase of a Fourier pattern."""

    sign: Literal[1, -1] = 1
    """-1 for the complement of a pattern."""

    start: float = 0.0
    """When the pattern begins, counted from the start of its frame, in frames; ``in_play_order`` sets it."""

    end: float = 1.0
    """When it ends."""

    @property
    def after_middle_frames(self) -> float:
        """Middle of the pattern against the middle of its frame, in frames."""
        return (self.start + self.end) / 2 - 0.5


def in_play_order(*columns: Column) -> tuple[Column, ...]:
    """Give the columns of a frame, shown one after the other for equally long, with the times of each."""
    count = len(columns)
    return tuple(
        column.model_copy(update={"start": k / count, "end": (k + 1) / count}) for k, column in enumerate(columns)
    )
