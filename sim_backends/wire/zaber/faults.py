"""Which fault strikes which command, reply and move (sheet, section 6)."""

from collections import Counter
from collections.abc import Sequence

from sim_backends.wire.zaber.settings import (
    Chatter,
    CorruptedByte,
    LostReply,
    Mute,
    OldReply,
    PortVanishes,
    Rejected,
    Stall,
    ZaberFault,
)


class Faults:
    """Counts as they strike."""

    def __init__(self, faults: Sequence[ZaberFault]) -> None:
        """Begin with nothing counted."""
        self._faults = faults
        self._seen: Counter[int] = Counter()
        self._replies = self._moves = 0
        self._now: set[type[ZaberFault]] = set()
        self._next: set[type[ZaberFault]] = set()
        self._before = b""

    def command(self, words: str) -> bool:
        """Count a command; tell whether the port is still there."""
        self._now |= self._next
        for number, fault in enumerate(self._faults):
            if isinstance(fault, PortVanishes | Mute) and words.startswith(fault.at):
                self._seen[number] += 1
                if self._seen[number] >= fault.nth:
                    (self._next if fault.behind else self._now).add(type(fault))
        return PortVanishes not in self._now

    def rejects(self, words: str) -> str | None:
        """Give the reason for which a command is rejected, or None."""
        for number, fault in enumerate(self._faults):
            if isinstance(fault, Rejected) and words.startswith(fault.at):
                self._seen[number] += 1
                if self._seen[number] == fault.nth:
                    return fault.word
        return None

    def stalls(self) -> float | None:
        """Count a move; give the part of its distance after which it stalls."""
        self._moves += 1
        stalls = [fault.after for fault in self._faults if isinstance(fault, Stall) and fault.nth == self._moves]
        return min(stalls, default=None)

    def reply(self, words: str, line: bytes, alert: bytes) -> bytes:
        """Give what is really sent of a reply, with what comes before it."""
        self._replies += 1
        if Mute in self._now:
            return b""
        ahead = b""
        for number, fault in enumerate(self._faults):
            if isinstance(fault, Chatter):
                ahead += alert
            elif isinstance(fault, OldReply) and self._replies == fault.nth:
                ahead += self._before
            elif isinstance(fault, LostReply | CorruptedByte) and words.startswith(fault.at):
                self._seen[number] += 1
                if self._seen[number] == fault.nth:
                    line = b"" if isinstance(fault, LostReply) else _corrupted(line, fault.byte)
        self._before = line or self._before
        return ahead + line


def _corrupted(line: bytes, byte: int) -> bytes:
    """Flip bit 4 of one byte."""
    place = min(byte, len(line) - 3)
    return line[:place] + bytes([line[place] ^ 0x10]) + line[place + 1 :]
