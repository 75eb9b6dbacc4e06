"""The counter: commands in, bins out, as the page on its protocol says."""

from sim_backends.bench import OpticalBench
from sim_backends.wire.seen_edges import SeenEdges
from sim_backends.wire.serial_box import SerialBox
from sim_backends.wire.serial_counter.settings import (
    CorruptedLine,
    CounterFault,
    LostLine,
    Mute,
    SerialCounterEmulatorSettings,
    Unplugged,
)

_LONGEST = 64


def crc(text: bytes) -> int:
    """CRC-8 with polynomial 0x07, bit by bit as firmware does it.

    >>> f"{crc(b'123456789'):02X}"
    'F4'
    """
    register = 0
    for byte in text:
        register ^= byte
        for _ in range(8):
            register = (register << 1 ^ (0x07 if register & 0x80 else 0)) & 0xFF
    return register


class CounterBox:
    """Takes bytes from ``box`` and answers on it."""

    def __init__(self, settings: SerialCounterEmulatorSettings, bench: OpticalBench) -> None:
        """Switch it on."""
        self._settings, self._bench = settings, bench
        self.box = SerialBox(bench.clock, settings.baud)
        self.box.take = self._byte
        self.box.look = self._look
        self._typed = b""
        self._commands = 0
        self._edges: SeenEdges | None = None
        self._n_bins = self._seen = 0
        self._last_tick: int | None = None
        self._first_s = 0.0
        self._full = False

    # Lines

    def _byte(self, byte: int, at_s: float) -> None:
        if byte != ord("\n"):
            self._typed = (self._typed + bytes([byte]))[: _LONGEST + 1]
            return
        line, self._typed = self._typed.rstrip(b"\r"), b""
        text, _, digits = line.rpartition(b"*")
        if len(line) > _LONGEST or not text or digits != b"%02X" % crc(text):
            return
        self._commands += 1
        self._look(at_s)
        self._say(self._answer(text.decode("ascii", "replace").split(","), at_s), at_s + self._settings.turnaround_s)

    def _say(self, text: str, at_s: float) -> None:
        if any(isinstance(fault, Mute) and self._commands >= fault.nth for fault in self._settings.faults):
            return
        data = text.encode("ascii", "replace")
        self.box.transmit(b"%s*%02X\n" % (data, crc(data)), at_s)

    def _answer(self, words: list[str], at_s: float) -> str:
        match words:
            case ["id"]:
                return f"id,Kinopix,{self._settings.model},1,{self._settings.ticks_hz}"
            case ["arm", number] if number.isdigit() and int(number) > 0:
                return self._arm(int(number), at_s)
            case ["stop"]:
                seen, self._edges = (0 if self._edges is None else self._seen), None
                return f"stopped,{seen}"
            case _:
                return "error,what"

    def _arm(self, n_bins: int, at_s: float) -> str:
        if self._edges is not None:
            return "error,armed already"
        self._edges = SeenEdges(self._bench, at_s)
        self._n_bins, self._seen, self._last_tick, self._full = n_bins, 0, None, False
        return f"armed,{n_bins}"

    # Edges

    def _look(self, until_s: float) -> None:
        """See the edges that have come until now, and put the bins that they close on the line."""
        if self._edges is None:
            return
        time_s, photons = self._edges.take(min(until_s, self._bench.clock.now_s()))
        for edge_s, count in zip(time_s.tolist(), photons.tolist(), strict=True):
            self._edge(edge_s, count)

    def _edge(self, edge_s: float, count: int) -> None:
        if self._last_tick is None:
            self._first_s = edge_s
        tick = round((edge_s - self._first_s) * self._settings.ticks_hz)
        index, before, self._last_tick = self._seen - 1, self._last_tick, tick
        self._seen += 1
        if before is None or index >= self._n_bins or self._full:
            return
        fault = self._fault(index)
        if isinstance(fault, Unplugged):
            self.box.vanished = True
        elif self.box.waiting(edge_s) > self._settings.memory_bytes:
            self._full = True
            self._say(f"overrun,{index}", edge_s)
        elif isinstance(fault, CorruptedLine):
            text = f"{index},{count},{tick - before}".encode()
            self.box.transmit(b"%s*%02X\n" % (text, crc(text) ^ 0x10), edge_s)
        elif not isinstance(fault, LostLine):
            self._say(f"{index},{count},{tick - before}", edge_s)

    def _fault(self, index: int) -> CounterFault | None:
        at = (fault for fault in self._settings.faults if not isinstance(fault, Mute) and fault.bin == index)
        return next(at, None)
