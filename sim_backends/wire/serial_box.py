"""The line side of a box on a serial line: when bytes come and go, and what the box does by itself later."""

import heapq
import itertools
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

from sim_backends.bench import BenchClock

_BITS_PER_BYTE = 10


@dataclass(order=True)
class _Event:
    time_s: float
    order: int
    act: Callable[[float], None] = field(compare=False)


class SerialBox:
    """A ``SerialDevice``: a byte takes effect when it has come over the line, and arrives at the host at its own time.

    Nothing here waits; time is the clock's. Safe to use from several threads. ``take`` and what ``at`` was given are called
    with the clock time of the moment at which they happen, in order.
    """

    def __init__(self, clock: BenchClock, baud: int) -> None:
        """Switch the box on.

        Args:
            clock: the bench's.
            baud: speed of the line; 10 bits a byte.
        """
        self.clock = clock
        self.baud = baud
        self.vanished = False
        """Whether the port is gone."""

        self.take: Callable[[int, float], None] = _ignore
        """What the box does with a byte that has come."""

        self.look: Callable[[float], None] = _nothing_seen
        """What the box does when the host looks for bytes, with the clock time: it may see to what has come about since."""

        self.received_s = 0.0
        """When the last byte of the host has come over the line."""

        self._lock = threading.RLock()
        self._byte_s = _BITS_PER_BYTE / baud
        self._out: deque[tuple[float, int]] = deque()
        self._line_out_s = 0.0
        self._events: list[_Event] = []
        self._order = itertools.count()

    def receive(self, data: bytes) -> None:
        """See ``SerialDevice``."""
        with self._lock:
            self._run_to(self.clock.now_s())
            self.received_s = max(self.received_s, self.clock.now_s())
            for byte in data:
                self.received_s += self._byte_s
                self._run_to(self.received_s)
                self.take(byte, self.received_s)

    def send(self) -> bytes:
        """See ``SerialDevice``."""
        with self._lock:
            now_s = self.clock.now_s()
            self._run_to(now_s)
            self.look(now_s)
            arrived = bytearray()
            while self._out and self._out[0][0] <= now_s:
                arrived.append(self._out.popleft()[1])
            return bytes(arrived)

    def next_s(self) -> float | None:
        """See ``SerialDevice``."""
        with self._lock:
            times = [self._out[0][0]] if self._out else []
            if self._events:
                times.append(self._events[0].time_s)
            return min(times, default=None)

    def transmit(self, data: bytes, from_s: float) -> None:
        """Send bytes that are ready ``from_s``, behind those already on their way."""
        self._line_out_s = max(self._line_out_s, from_s)
        for byte in data:
            self._line_out_s += self._byte_s
            self._out.append((self._line_out_s, byte))

    def waiting(self, at_s: float) -> int:
        """Give the bytes that are not out of the box at a moment."""
        return max(0, round((self._line_out_s - at_s) / self._byte_s))

    def at(self, time_s: float, act: Callable[[float], None]) -> None:
        """Do something at a moment on the clock."""
        heapq.heappush(self._events, _Event(time_s, next(self._order), act))

    def _run_to(self, time_s: float) -> None:
        while self._events and self._events[0].time_s <= time_s:
            event = heapq.heappop(self._events)
            event.act(event.time_s)


def _ignore(byte: int, at_s: float) -> None:
    """A box without ears."""
    del byte, at_s


def _nothing_seen(now_s: float) -> None:
    """A box without eyes."""
    del now_s
