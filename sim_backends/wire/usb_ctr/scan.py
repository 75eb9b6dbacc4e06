"""A counter scan: from latched words to packets in the FIFO (h10682-daq.md 5.1 and 5.2)."""

import struct
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from protocols import Integers
from sim_backends.wire.usb_ctr.counters import Moments, Register
from sim_backends.wire.usb_ctr.settings import ClearRace, ScanFault, UsbCtrEmulatorSettings

KEEP_COUNTERS = 0x01
_FULL_PACKET_WORDS = 256
_START = struct.Struct("<IIIBB")
_DIO, _ZERO_FILL = 0x20, 0x40


@dataclass(frozen=True)
class Start:
    """The 14 bytes of SCAN_START."""

    scans: int
    """Number of scans; 0: until it is stopped."""

    retriggers: int
    pacer_period: int
    """0: a scan at each edge of the external clock; otherwise at 96 MHz / (period + 1)."""

    packet_words: int
    options: int

    @classmethod
    def parse(cls, data: bytes) -> "Start":
        """Take the bytes apart.

        Raises:
            struct.error: not 14 of them.
        """
        scans, retriggers, period, words, options = _START.unpack(data)
        return cls(scans, retriggers, period, words + 1, options)


class Scan:
    """A running or ended scan. It is fed with moments and fills the FIFO."""

    def __init__(self, settings: UsbCtrEmulatorSettings, elements: bytes, start: Start, started_s: float) -> None:
        self.start = start
        self.started_s = started_s
        self.done = 0
        self.running = True
        self.complete = False
        self.overrun = False
        self.pacer_overrun = False
        self.disconnected = False
        self.waiting_bytes = 0
        """What the FIFO holds, the packet that is not full included."""
        self._fifo: deque[bytes] = deque()
        self._settings = settings
        self._elements = elements
        self._partial = bytearray()
        self._sent = 0
        self._cut_bytes = 0
        self._max_packet = 512 if settings.high_speed else 64
        self._last_s = -np.inf
        self._faults = sorted(
            (fault for fault in settings.faults if isinstance(fault, ScanFault)), key=lambda fault: fault.at
        )

    @property
    def _scan_bytes(self) -> int:
        return 2 * len(self._elements)

    @property
    def _packet_bytes(self) -> int:
        """Bytes of the packet in the making, without what a fault has sent of it too early."""
        return 2 * self.start.packet_words - self._cut_bytes

    def scans_to_packet(self) -> int:
        """How many more scans make a packet, or end the scan."""
        scans = -(-(self._packet_bytes - len(self._partial)) // self._scan_bytes)
        if self.start.scans:
            scans = min(scans, self.start.scans - self.done)
        ends = [fault.at - self.done + 1 for fault in self._faults]
        return max(1, min([scans, *(n for n in ends if n > 0)]))

    def feed(self, at: Moments, latch: Callable[[int, Moments], Register]) -> None:
        """Take scans at these moments, until the scan is complete or a fault ends it.

        Args:
            at: moments, in order.
            latch: reads (and clears, where set) a counter at moments.
        """
        room = len(at.time_s)
        if self.start.scans:
            room = min(room, self.start.scans - self.done)
        room, broken = self._good(at, room)
        taken = Moments(at.time_s[:room], self._raced(at.photons[:room]), at.edges[:room])
        if room:
            self._last_s = float(taken.time_s[-1])
            words = self._words(taken, latch)
            for row in words.astype("<u2"):
                self._put(row.tobytes())
                if not self.running:
                    return
        if broken is not None:
            self._break(broken)
        elif self.start.scans and self.done >= self.start.scans:
            self._end()

    def _good(self, at: Moments, room: int) -> tuple[int, str | None]:
        """How many of the scans are taken, and what ends them."""
        broken: str | None = None
        for fault in self._faults:
            if fault.kind in ("overrun", "pacer-overrun", "disconnect") and 0 <= fault.at - self.done < room:
                room, broken = fault.at - self.done, fault.kind
        least_s = len(self._elements) / self._settings.max_words_per_s
        gap_s = at.time_s[:room] - np.concatenate([[self._last_s], at.time_s[:room]])[:room]
        fast = np.flatnonzero(gap_s < least_s)
        return (int(fast[0]), "pacer-overrun") if len(fast) else (room, broken)

    def _raced(self, photons: Integers) -> Integers:
        """Photon totals as the latch sees them."""
        seen = photons.copy()
        for fault in self._settings.faults:
            if isinstance(fault, ClearRace) and 0 <= fault.at - self.done < len(seen):
                seen[fault.at - self.done] -= fault.counts
        return seen

    def _words(self, at: Moments, latch: Callable[[int, Moments], Register]) -> Integers:
        """``(n, elements)``: each counter is latched once a scan, then its banks are taken."""
        latched: dict[int, Register] = {}
        columns: list[Integers] = []
        for element in self._elements:
            counter, bank = element & 0x07, element >> 3 & 0x03
            if element & _DIO or (element & _ZERO_FILL and self._settings.zero_fill_works):
                columns.append(np.zeros(len(at.time_s), np.int64))
                continue
            if counter not in latched:
                latched[counter] = latch(counter, at)
            columns.append((latched[counter] >> np.uint64(16 * bank) & np.uint64(0xFFFF)).astype(np.int64))
        return np.stack(columns, axis=1)

    def _put(self, data: bytes) -> None:
        """Add one scan to the packet in the making."""
        here = [fault.kind for fault in self._faults if fault.at == self.done]
        self.done += 1
        if "zero-length-packet" in here:
            self._fifo.append(b"")
        self._partial += data
        self.waiting_bytes += len(data)
        if "short-packet" in here and len(self._partial) > 2:
            cut = len(self._partial) // 4 * 2
            self._send(bytes(self._partial[:cut]))
            self._cut_bytes = cut
        while len(self._partial) >= self._packet_bytes:
            self._send(bytes(self._partial[: self._packet_bytes]))
            self._cut_bytes = 0
        if self.waiting_bytes > self._settings.fifo_bytes:
            self._break("overrun")

    def _send(self, packet: bytes) -> None:
        del self._partial[: len(packet)]
        self._sent += len(packet)
        step = self._max_packet
        self._fifo.extend(packet[at : at + step] for at in range(0, len(packet), step))

    def _end(self) -> None:
        """All scans are in: send the rest, and say with an empty packet that there is no more."""
        self.running, self.complete = False, True
        if self._settings.flush_at_end and self._partial and self.start.packet_words == _FULL_PACKET_WORDS:
            self._send(bytes(self._partial))
        last = len(self._fifo[-1]) if self._fifo else 0
        rule = self._settings.zero_length_packet
        full = last == self._max_packet if rule == "full-packet" else self._sent % self._max_packet == 0
        if rule != "never" and self._sent and full:
            self._fifo.append(b"")

    def _break(self, kind: str) -> None:
        self.running = False
        self.overrun |= kind == "overrun"
        self.pacer_overrun |= kind == "pacer-overrun"
        self.disconnected |= kind == "disconnect"

    def stop(self) -> None:
        """Stop scanning. A packet that is not full is never sent."""
        self.running = False

    def clear(self) -> None:
        """Empty the FIFO."""
        self._fifo.clear()
        self._partial.clear()
        self.waiting_bytes = 0

    @property
    def next_packet(self) -> bytes | None:
        """The packet that goes next; None while there is none."""
        return self._fifo[0] if self._fifo else None

    def pop(self) -> None:
        """Let the next packet go."""
        self.waiting_bytes -= len(self._fifo.popleft())
