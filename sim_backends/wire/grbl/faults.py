"""Which fault strikes which line, answer and jog (sheet, section 6)."""

from collections import Counter
from collections.abc import Sequence

from sim_backends.wire.grbl.settings import (
    CorruptedByte,
    Error,
    GrblFault,
    LateReply,
    LostReply,
    Mute,
    NoSwitch,
    PortVanishes,
    Reset,
    Stall,
)


class Faults:
    """Counts as they strike."""

    def __init__(self, faults: Sequence[GrblFault]) -> None:
        """Begin with nothing counted."""
        self._faults = faults
        self._seen: Counter[int] = Counter()
        self._jogs = 0
        self._now: set[type[GrblFault]] = set()
        self._next: set[type[GrblFault]] = set()

    @property
    def no_switch(self) -> bool:
        """Whether homing finds no switch."""
        return any(isinstance(fault, NoSwitch) for fault in self._faults)

    def command(self, line: str) -> type[PortVanishes | Reset] | None:
        """Count a line or a real-time byte; give what befalls it."""
        resets = Reset in self._next
        self._now |= self._next
        self._next.discard(Reset)
        for number, fault in enumerate(self._faults):
            if not (isinstance(fault, PortVanishes | Mute | Reset) and line.startswith(fault.at)):
                continue
            self._seen[number] += 1
            if isinstance(fault, Reset):
                if self._seen[number] == fault.nth and fault.behind:
                    self._next.add(Reset)
                resets |= self._seen[number] == fault.nth and not fault.behind
            elif self._seen[number] >= fault.nth:
                (self._next if fault.behind else self._now).add(type(fault))
        if PortVanishes in self._now:
            return PortVanishes
        return Reset if resets else None

    def error(self, line: str) -> int | None:
        """Give the error that a line is answered with, or None."""
        for number, fault in enumerate(self._faults):
            if isinstance(fault, Error) and line.startswith(fault.at):
                self._seen[number] += 1
                if self._seen[number] == fault.nth:
                    return fault.code
        return None

    def stalls(self) -> float | None:
        """Count a jog; give the part of its distance after which it stalls."""
        self._jogs += 1
        return min((f.after for f in self._faults if isinstance(f, Stall) and f.nth == self._jogs), default=None)

    def answer(self, asked: str, line: bytes) -> tuple[bytes, float]:
        """Give what is really sent of a line, and how late in seconds."""
        late_s = 0.0
        if Mute in self._now:
            return b"", late_s
        for number, fault in enumerate(self._faults):
            if isinstance(fault, LostReply | LateReply | CorruptedByte) and asked.startswith(fault.at):
                self._seen[number] += 1
                if self._seen[number] != fault.nth:
                    continue
                if isinstance(fault, LateReply):
                    late_s = fault.delay_s
                else:
                    line = b"" if isinstance(fault, LostReply) else _corrupted(line, fault.byte)
        return line, late_s


def _corrupted(line: bytes, byte: int) -> bytes:
    """Flip bit 4 of one byte."""
    place = min(byte, len(line) - 3)
    return line[:place] + bytes([line[place] ^ 0x10]) + line[place + 1 :]
