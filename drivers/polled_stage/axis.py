"""What a controller must be able to do and to tell."""

from dataclasses import dataclass
from typing import Protocol

from protocols import MotionProfile


@dataclass(frozen=True)
class Status:
    """What a controller has told about itself."""

    time_s: float
    """The middle between question and answer, in seconds on the bench's clock."""

    mm: float | None
    """Position in millimetres; None where the controller does not tell it now."""

    moving: bool
    """Whether it moves, by its own word."""

    homed: bool
    """Whether it knows its origin, by its own word."""

    trouble: str = ""
    """What it says is wrong, in words; empty where nothing is."""


class Axis(Protocol):
    """One axis of a controller. Only ``send_stop`` may be called while another call is under way."""

    @property
    def tolerance_mm(self) -> float:
        """Difference up to which two positions are the same, in millimetres."""
        ...

    @property
    def stops(self) -> int:
        """How many stops have been sent."""
        ...

    def status(self) -> Status:
        """Ask the controller.

        Raises:
            DeviceTimeout: no answer.
            DeviceDisconnected: the port is gone.
        """
        ...

    def check(self, profile: MotionProfile) -> None:
        """Refuse a profile that lies within the limits and yet cannot be run.

        Raises:
            PlanError: names what cannot be.
        """
        ...

    def runs(self, profile: MotionProfile) -> MotionProfile:
        """Give the profile that the controller really runs, in its own whole steps."""
        ...

    def begin_move(self, target_mm: float, profile: MotionProfile, *, stops: int) -> None:
        """Start a move, unless a stop came after ``stops``; returns when the controller has taken it.

        Raises:
            DeviceRefused: the controller does not take it; nothing moves.
            DeviceTimeout: no answer; it may move.
            DeviceError: a stop came first; nothing was sent.
        """
        ...

    def begin_home(self, profile: MotionProfile, *, stops: int) -> None:
        """Start to look for the origin; as ``begin_move``."""
        ...

    def send_stop(self) -> None:
        """Send a stop, now, whatever else is going on, and wait for no answer."""
        ...

    def close(self) -> None:
        """Give the line back."""
        ...
