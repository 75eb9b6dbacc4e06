"""One run under way: when it should end, and what is said when it does not."""

from dataclasses import dataclass
from typing import Final

from drivers.alp.board import AlpBoard
from protocols.errors import DeviceError, DeviceTimeout, KinopixError

CLOCK_TOLERANCE: Final = 0.01
"""Share of a run by which it may end sooner than by the host's clock: far more than two crystals differ by."""


@dataclass
class Run:
    """A play order that is being played."""

    pictures: int
    """Pictures to show, the guard included."""

    picture_time_s: float
    """Start of one picture to the start of the next."""

    started_s: float
    """Just before the board was told to start, on the host's clock."""

    halted: bool = False
    """Whether a halt cut it short."""

    @property
    def duration_s(self) -> float:
        """First picture's start to last picture's end."""
        return self.pictures * self.picture_time_s

    @property
    def end_s(self) -> float:
        """Expected end on the host's clock."""
        return self.started_s + self.duration_s

    @property
    def earliest_end_s(self) -> float:
        """Start of the last picture, within the tolerance: no sound run is idle before it."""
        return self.started_s + (self.pictures - 1) * self.picture_time_s * (1 - CLOCK_TOLERANCE)


def ended_early(run: Run, now_s: float, device: str) -> DeviceError:
    """Say that the board stopped by itself."""
    return DeviceError(
        device=device,
        saw=f"an idle board {now_s - run.started_s:.3g} s after the start",
        expected=f"{run.pictures} pictures for {run.duration_s:.3g} s",
        remedy="check the board's power and USB cable, and that no other program halts it; treat the run as partial",
    )


def timed_out(run: Run, timeout_s: float, board: AlpBoard) -> DeviceTimeout:
    """Say how far the run has come, as the board counts it."""
    try:
        shown = f"{max(0, run.pictures - board.pictures_left())} of {run.pictures} pictures shown"
    except KinopixError:
        shown = f"still playing {run.pictures} pictures (the board does not tell how many are left)"
    short = timeout_s < run.duration_s
    return DeviceTimeout(
        board.name,
        awaited=f"{run.pictures} pictures, which take {run.duration_s:.3g} s",
        waited_s=timeout_s,
        progress=shown,
        remedy="wait longer: the run is not over yet" if short else "halt the board and check its clock and USB cable",
    )
