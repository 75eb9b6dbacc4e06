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
        self._commands = self._jogs = 0

    @property
    def no_switch(self) -> bool:
        """Whether homing finds no switch."""
        return any(isinstance(fault, NoSwitch) for fault in self._faults)

    def command(self) -> type[PortVanishes | Reset] | None:
        """Count a line or a real-time byte; give what befalls it."""
        self._commands += 1
        for fault in self._faults:
            if isinstance(fault, PortVanishes) and self._commands >= fault.nth:
                return PortVanishes
            if isinstance(fault, Reset) and self._commands == fault.nth:
                return Reset
        return None

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
        if any(isinstance(fault, Mute) and self._commands >= fault.nth for fault in self._faults):
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
