"""Faults of the line and of the motor, counted as they strike (ka400z.md 3F)."""

from collections import Counter
from collections.abc import Sequence

from sim_backends.wire.zolix.settings import (
    CorruptedByte,
    DuplicatedCompletion,
    LateCompletion,
    LimitSticks,
    LostReply,
    Mute,
    PortVanishes,
    StageFault,
    Stall,
)

COMPLETION = "completion"
"""What a completion line answers, for faults that name it."""


class Faults:
    """Which fault strikes which line."""

    def __init__(self, faults: Sequence[StageFault]) -> None:
        """Begin with nothing counted."""
        self._faults = faults
        self._seen: Counter[int] = Counter()
        self._now: set[type[StageFault]] = set()
        self._next: set[type[StageFault]] = set()
        self.completions = 0
        self.moves = 0

    @property
    def limit_sticks(self) -> bool:
        """Whether a limit switch is never released."""
        return any(isinstance(fault, LimitSticks) for fault in self._faults)

    def command(self, line: str) -> bool:
        """Count a command; tell whether the port is still there."""
        self._now |= self._next
        for number, fault in enumerate(self._faults):
            if isinstance(fault, PortVanishes | Mute) and line.upper().startswith(fault.at.upper()):
                self._seen[number] += 1
                if self._seen[number] >= fault.nth:
                    (self._next if fault.behind else self._now).add(type(fault))
        return PortVanishes not in self._now

    def move(self) -> float | None:
        """Count a move; give the part of its distance after which the motor stalls."""
        self.moves += 1
        stalls = [fault.after for fault in self._faults if isinstance(fault, Stall) and fault.nth == self.moves]
        return min(stalls, default=None)

    def completion_times(self, end_s: float) -> list[float]:
        """Count a completion; give the moments at which its line is sent."""
        self.completions += 1
        mine = [fault for fault in self._faults if getattr(fault, "nth", 0) == self.completions]
        at_s = end_s + sum(fault.delay_s for fault in mine if isinstance(fault, LateCompletion))
        return [at_s] * (1 + sum(isinstance(fault, DuplicatedCompletion) for fault in mine))

    def line(self, answers: str, line: bytes) -> bytes:
        """Give what is really sent of a reply line.

        Args:
            answers: the command, or ``COMPLETION``.
            line: with its CR.
        """
        if Mute in self._now:
            return b""
        for number, fault in enumerate(self._faults):
            if isinstance(fault, LostReply | CorruptedByte) and answers.upper().startswith(fault.at.upper()):
                self._seen[number] += 1
                if self._seen[number] == fault.nth:
                    line = b"" if isinstance(fault, LostReply) else _corrupted(line, fault.byte)
        return line


def _corrupted(line: bytes, byte: int) -> bytes:
    """Flip bit 4 of one byte: the classic of a bad cable."""
    if len(line) < 2:
        return line
    place = min(byte, len(line) - 2)
    return line[:place] + bytes([line[place] ^ 0x10]) + line[place + 1 :]
