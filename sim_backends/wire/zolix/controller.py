"""A Zolix box as a byte machine: bytes in, bytes out, each at its time (ka400z.md 3E)."""

import heapq
import itertools
import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Protocol, TypeAlias

from protocols import Floats
from sim_backends.bench import BenchClock
from sim_backends.wire.stepper.axis import Axis
from sim_backends.wire.zolix.faults import COMPLETION, Faults
from sim_backends.wire.zolix.settings import Mc600Settings, Sc300Settings

BoxSettings: TypeAlias = Mc600Settings | Sc300Settings
"""Settings of a box of either dialect."""

CarryObject: TypeAlias = Callable[[Callable[[Floats], Floats]], None]
"""Function that is told how the object is carried: clock seconds ``(n,)`` to mm ``(n,)``."""

_LONGEST_LINE = 256
"""A line without CR that grows longer is thrown away."""


@dataclass(frozen=True)
class Answer:
    """What a command leads to."""

    lines: tuple[str, ...] = ()
    """Lines of the reply, sent at once."""

    moved: tuple[str, ...] = ()
    """Axes whose motion it started or ended."""

    completes: bool = True
    """Whether each of them sends a completion line when it stands."""

    stored: bool = False
    """Whether something was written to the EEPROM."""


class Dialect(Protocol):
    """What the lines of one kind of box mean."""

    def execute(self, command: str, now_s: float) -> Answer:
        """Carry out one command, without its CR."""
        ...

    def completion(self, axis: str, now_s: float) -> str:
        """Line that tells the end of a motion."""
        ...

    def is_stop(self, command: str) -> bool:
        """Whether a command stops a motion."""
        ...

    @property
    def bad_line(self) -> str:
        """Answer to a line that breaks the framing."""
        ...


@dataclass(order=True)
class _Event:
    time_s: float
    order: int
    act: Callable[[float], None] = field(compare=False)


class EmulatedController:
    """One box on one serial line. Safe to use from several threads.

    A command takes effect at the moment at which its last byte has come over the line, and a reply can be read byte by
    byte as it arrives: ten bits a byte. Nothing here waits; time is the clock's.
    """

    def __init__(
        self,
        settings: BoxSettings,
        clock: BenchClock,
        dialect: Callable[[dict[str, Axis], Faults], Dialect],
        carry: CarryObject | None = None,
        axes: str = "X",
    ) -> None:
        """Switch the box on.

        Args:
            settings: mechanics, line and habits.
            clock: the bench's.
            dialect: builds the dialect on the axes.
            carry: told each time the object's axis begins to move otherwise.
            axes: names of the axes.
        """
        self.settings = settings
        self.clock = clock
        self._lock = threading.RLock()
        self._carry = carry
        self.faults = Faults(settings.faults)
        start = round(settings.start_mm * settings.pulses_per_mm)
        self.axes = {name: self._axis(start) for name in axes}
        self._dialect = dialect(self.axes, self.faults)
        self._order = itertools.count()
        self._events: list[_Event] = []
        self._held: deque[str] = deque()
        self._typed = bytearray()
        self._line_in_s = self._busy_s = self._line_out_s = 0.0
        self._out: deque[tuple[float, int]] = deque()
        self.vanished = False
        """Whether the port is gone."""
        self._tell_bench()

    def _axis(self, start: int) -> Axis:
        settings, pulses = self.settings, self.settings.pulses_per_mm
        low, high = (round(limit * pulses) for limit in settings.travel_mm)
        backlash, sticks = round(settings.backlash_mm * pulses), self.faults.limit_sticks
        return Axis(low=low, high=high, start=start, backlash=backlash, limit_sticks=sticks)

    # Where the carriage is, was told to be, and is said to be: three figures that a fault tells apart

    def true_position_mm(self, clock_s: Floats) -> Floats:
        """Where the carriage really is, ``(n,)``, from its home position."""
        return self._millimetres()(clock_s)

    def _millimetres(self) -> Callable[[Floats], Floats]:
        path, settings = self.axes[self.settings.axis].carriage, self.settings
        mm = (1 + settings.lead_error) / settings.pulses_per_mm
        return lambda clock_s: path.at(clock_s) * mm

    def commanded_mm(self) -> float:
        """Where the present or last motion was told to go, on the controller's counter."""
        return self.axes[self.settings.axis].target / self.settings.pulses_per_mm

    def reported_mm(self) -> float:
        """What the controller's counter says now."""
        return self.axes[self.settings.axis].reported(self.clock.now_s()) / self.settings.pulses_per_mm

    def _tell_bench(self) -> None:
        if self._carry is not None:
            self._carry(self._millimetres())

    # The line

    @property
    def baud(self) -> int:
        """Speed of the line."""
        return self.settings.baud

    @property
    def _byte_s(self) -> float:
        return 10 / self.settings.baud

    def receive(self, data: bytes) -> None:
        """Take bytes that the host begins to send now."""
        with self._lock:
            self._run_to(self.clock.now_s())
            self._line_in_s = max(self._line_in_s, self.clock.now_s())
            for byte in data:
                self._line_in_s += self._byte_s
                if byte != 0x0D:
                    self._typed = self._typed[-_LONGEST_LINE:]
                    self._typed.append(byte)
                    continue
                line, self._typed = bytes(self._typed), bytearray()
                self._command(line)

    @property
    def received_s(self) -> float:
        """When the last byte of the host has come over the line."""
        return self._line_in_s

    def send(self) -> bytes:
        """Give the bytes that have arrived at the host since the last call."""
        with self._lock:
            self._run_to(self.clock.now_s())
            arrived = bytearray()
            while self._out and self._out[0][0] <= self.clock.now_s():
                arrived.append(self._out.popleft()[1])
            return bytes(arrived)

    def next_s(self) -> float | None:
        """When it is worth looking again: the next byte, or the next thing that may bring one. None: never."""
        with self._lock:
            times = [self._out[0][0]] if self._out else []
            if self._events:
                times.append(self._events[0].time_s)
            return min(times, default=None)

    # The box

    def _command(self, line: bytes) -> None:
        """Take a line whose CR comes at ``_line_in_s``: nothing can come between, so it is carried out at once."""
        command = line.replace(b"\n", b"").decode("ascii", "replace")
        if not self.faults.command(command):
            self.vanished = True
            return
        start_s = max(self._line_in_s + self.settings.turnaround_s, self._busy_s)
        self._run_to(start_s)
        if self.settings.echo:
            self._transmit(start_s, line.decode("ascii", "replace"), "echo")
        if b"\n" in line and self.settings.strict_lf:
            self._transmit(start_s, self._dialect.bad_line, "")
            return
        if self._moving(start_s) and not self._may_interrupt(command):
            if self.settings.busy_policy == "queue":
                self._held.append(command)
            return
        self._execute(command, start_s)

    def _moving(self, now_s: float) -> bool:
        return any(axis.moving(now_s) for axis in self.axes.values())

    def _may_interrupt(self, command: str) -> bool:
        stops = self.settings.stop_works_moving and self._dialect.is_stop(command)
        return stops or self.settings.busy_policy == "answer"

    def _execute(self, command: str, now_s: float) -> None:
        answer = self._dialect.execute(command, now_s)
        reply_s = now_s + (self.settings.eeprom_s if answer.stored else 0.0)
        self._busy_s = reply_s
        for line in answer.lines:
            self._transmit(reply_s, line, command)
        for name in answer.moved:
            self._await_arrival(name, now_s, tell=answer.completes)
        if self.settings.axis in answer.moved:
            self._tell_bench()

    def _await_arrival(self, name: str, now_s: float, *, tell: bool) -> None:
        axis, motion = self.axes[name], self.axes[name].motion

        def arrive(end_s: float) -> None:
            # Another motion may have taken the place of this one.
            if axis.motion != motion:
                return
            if tell:
                line = self._dialect.completion(name, end_s)
                for time_s in self.faults.completion_times(end_s):
                    self._at(time_s, lambda now_s: self._transmit(now_s, line, COMPLETION))
            while self._held and not self._moving(end_s):
                self._execute(self._held.popleft(), end_s)

        self._at(max(axis.end_s, now_s), arrive)

    def _at(self, time_s: float, act: Callable[[float], None]) -> None:
        heapq.heappush(self._events, _Event(time_s, next(self._order), act))

    def _run_to(self, time_s: float) -> None:
        while self._events and self._events[0].time_s <= time_s:
            event = heapq.heappop(self._events)
            event.act(event.time_s)

    def _transmit(self, now_s: float, line: str, answers: str) -> None:
        self._line_out_s = max(self._line_out_s, now_s)
        for byte in self.faults.line(answers, line.encode("ascii", "replace") + b"\r"):
            self._line_out_s += self._byte_s
            self._out.append((self._line_out_s, byte))
