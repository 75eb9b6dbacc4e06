"""Where the stage was during a run, as its controller told."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

import numpy as np

from protocols import Floats, Mask, StagePosition

COLUMNS = 4
"""Numbers of a row as the file has it: time, reported and commanded position, whether the reported one is predicted."""


@dataclass(frozen=True, eq=False)
class StageLog:
    """Positions before, during and after a run. Where the controller is mute in motion, those during it are predictions."""

    time_s: Floats
    """``(n,)`` on the host's clock, from the start of the modulator on: the first is before it, and before the motion."""

    reported_mm: Floats
    """``(n,)``: position told."""

    commanded_mm: Floats
    """``(n,)``: target of the motion under way."""

    predicted: Mask
    """``(n,)``: whether the controller was mute, so that the position follows from the profile."""

    @classmethod
    def of(cls, positions: Sequence[StagePosition], start_s: float) -> Self:
        """Take positions, with the moment on their clock at which the modulator was started."""
        return cls(
            np.array([position.time_s - start_s for position in positions], np.float64),
            np.array([position.reported_mm for position in positions], np.float64),
            np.array([position.commanded_mm for position in positions], np.float64),
            np.array([position.predicted for position in positions], np.bool_),
        )

    @classmethod
    def of_rows(cls, rows: Floats) -> Self:
        """Read ``(n, 4)`` rows of a file."""
        return cls(rows[:, 0], rows[:, 1], rows[:, 2], rows[:, 3] > 0)

    @property
    def rows(self) -> Floats:
        """``(n, 4)``: as the file has it."""
        columns = (self.time_s, self.reported_mm, self.commanded_mm, self.predicted.astype(np.float64))
        return np.stack(columns, axis=1)

    def __len__(self) -> int:
        """Give the number of positions."""
        return len(self.time_s)
