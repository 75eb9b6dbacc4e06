"""The one owner of the port: it writes, reads, and sorts every line into answer, end of a motion, or surplus.

There is no reader thread. Whoever waits reads, under ``turn``, and all waiting is on the bench's clock. A stop waits for no
reader: it needs only the lock round the write, and no answer.

The dialects have neither checksums nor numbers that tie an answer to its question. So after anything that may have left an
answer under way (a time-out, a stop, the probing, one answer too many) the next exchange begins with a *fence*: a query whose
answer looks like no other. Controllers answer in order; what comes before the fence's answer is old and is dropped.
"""

import logging
from collections import deque
from dataclasses import dataclass
from threading import Lock, RLock
from typing import Final

from drivers.serial_line import BITS_PER_BYTE, SerialPort, port_gone, stopped_before
from drivers.zolix.events import (
    BAUD,
    LONGEST_LINE,
    Codec,
    Command,
    Event,
    Lines,
    Named,
    Okay,
    Position,
    Ready,
    Refused,
    Unknown,
    Value,
)
from protocols import Clock, DeviceRefused, DeviceTimeout

_log = logging.getLogger(__name__)
_KEPT: Final = 200
_QUIET_S: Final = 0.02
"""Silence before a command: an answer that comes twice is over by then. Field codes wait 20 to 25 ms (sections 3A, 3B)."""


@dataclass(frozen=True)
class Reply:
    """An answer, and when it holds."""

    event: Event

    time_s: float
    """The middle between question and answer."""


class Wire:
    """Bytes out, sorted events in."""

    def __init__(
        self, port: SerialPort, codec: Codec, clock: Clock, *, device: str, reply_margin_s: float, poll_s: float
    ) -> None:
        self.turn: Final = RLock()
        """Held by whoever reads. A stop does not take it."""

        self.endings: Final[deque[Event]] = deque(maxlen=_KEPT)
        """Unasked lines that may mean that a motion is over; whoever watches the motion takes them."""

        self.surplus: Final[deque[Event]] = deque(maxlen=_KEPT)
        """The last lines that nobody could use."""

        self.stops = 0
        """How many stops have been sent."""

        self.clock: Final = clock
        self.device: Final = device
        self._port = port
        self._codec = codec
        self._lines = Lines()
        self._margin_s = reply_margin_s
        self._poll_s = poll_s
        self._write_lock = Lock()
        self._seen = b""
        self._last_byte_s = clock.now_s()
        self._doubtful = True
        self._fenced_stops = 0

    def exchange(self, command: Command) -> Reply:
        """Send ``command`` and wait for its answer.

        Raises:
            DeviceTimeout: no such answer within the time of the bytes on the line plus the margin.
            DeviceRefused: the controller answered with an error.
            DeviceDisconnected: the port is gone.
        """
        with self.turn:
            self._clear()
            return self._await(command, refusable=True)

    def begin(self, command: Command, *, unless_stopped_since: int) -> float:
        """Send a motion command, unless a stop was sent after ``unless_stopped_since``, and wait until it is taken.

        Returns the time at which the last byte has left.

        Raises:
            DeviceError: a stop came first; nothing was sent.
            DeviceTimeout, DeviceRefused, DeviceDisconnected: as ``exchange``.
        """
        with self.turn:
            self._clear()
            self.endings.clear()
            if command.awaits is None:
                self._write(command.data, unless_stopped_since)
                return self.clock.now_s() + _line_time_s(len(command.data))
            sent_s = self.clock.now_s()
            self._await(command, refusable=True, unless_stopped_since=unless_stopped_since)
        return sent_s + _line_time_s(len(command.data))

    def stop(self) -> None:
        """Send the stop, now, whatever else is going on."""
        with self._write_lock:
            self.stops += 1
            self._put(self._codec.stop())

    def pump(self) -> None:
        """Take in what has arrived, without waiting."""
        with self.turn:
            self._take(None, refusable=False)

    def close(self) -> None:
        """Give the port back."""
        self._port.close()

    @property
    def seen(self) -> bytes:
        """What has come in since the last command."""
        return self._seen

    def _await(self, command: Command, *, refusable: bool, unless_stopped_since: int | None = None) -> Reply:
        self._seen = b""
        sent_s = self.clock.now_s()
        self._write(command.data, unless_stopped_since)
        limit_s = _line_time_s(len(command.data) + LONGEST_LINE) + self._margin_s
        while True:
            event = self._take(command.awaits, refusable=refusable)
            now_s = self.clock.now_s()
            if isinstance(event, Refused):
                raise DeviceRefused(
                    self.device,
                    code=event.code,
                    saw=f"an error in answer to {command.data!r}",
                    expected=_name(command.awaits),
                    remedy="see whether a limit switch is held or the stage still moves; what the codes mean is not published",
                )
            if event is not None:
                return Reply(event, (sent_s + now_s) / 2)
            if now_s - sent_s >= limit_s:
                self._doubtful = True
                raise DeviceTimeout(
                    self.device,
                    awaited=f"{_name(command.awaits)} in answer to {command.data!r}",
                    waited_s=now_s - sent_s,
                    progress=f"only {self._seen!r}" if self._seen else "not a byte",
                    remedy="check the cable, the power and the dialect; a stage in motion may be mute",
                )
            self.clock.sleep_s(self._poll_s)

    def _clear(self) -> None:
        """Take in what is old until the line is quiet, drop a line that was cut off, and fence where in doubt."""
        until_s = self.clock.now_s() + _line_time_s(4 * LONGEST_LINE)
        while True:
            self._take(None, refusable=False)
            now_s = self.clock.now_s()
            quiet = not self._lines.pending and now_s - self._last_byte_s >= _QUIET_S
            if quiet or now_s >= until_s:
                break
            self.clock.sleep_s(self._poll_s)
        if lost := self._lines.discard():
            self._doubtful = True
            self._keep(Unknown(lost))
        if self._doubtful or self._fenced_stops != self.stops:
            stops = self.stops
            self._await(self._codec.fence(), refusable=False)
            self._doubtful, self._fenced_stops = False, stops

    def _take(self, awaited: type[Event] | None, *, refusable: bool) -> Event | None:
        data = self._read()
        if data:
            self._last_byte_s = self.clock.now_s()
        self._seen = (self._seen + data)[-4 * LONGEST_LINE :]
        answer: Event | None = None
        for event in map(self._codec.classify, self._lines.feed(data)):
            fits = awaited is not None and (isinstance(event, awaited) or (refusable and isinstance(event, Refused)))
            if answer is None and fits:
                answer = event
                continue
            ends = isinstance(event, self._codec.may_end_a_motion)
            # an answer to nothing: one more than asked for, so the next may be one too late
            self._doubtful |= isinstance(event, Okay | Ready | Value | Named) or (
                isinstance(event, Position) and not ends
            )
            if ends:
                self.endings.append(event)
            else:
                self._keep(event)
        return answer

    def _keep(self, event: Event) -> None:
        self.surplus.append(event)
        _log.log(logging.WARNING if isinstance(event, Unknown) else logging.DEBUG, "%s: unasked %s", self.device, event)

    def _read(self) -> bytes:
        try:
            waiting = self._port.in_waiting
            return self._port.read(waiting) if waiting else b""
        except OSError as error:
            raise port_gone(self.device, error) from error

    def _write(self, data: bytes, unless_stopped_since: int | None) -> None:
        with self._write_lock:
            if unless_stopped_since is not None and self.stops != unless_stopped_since:
                raise stopped_before(self.device)
            self._put(data)

    def _put(self, data: bytes) -> None:
        try:
            self._port.write(data)
        except OSError as error:
            raise port_gone(self.device, error) from error


def _line_time_s(n_bytes: int) -> float:
    return n_bytes * BITS_PER_BYTE / BAUD


def _name(awaited: type[Event] | None) -> str:
    return "nothing" if awaited is None else awaited.__name__
