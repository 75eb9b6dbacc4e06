"""Lines out and in. Whoever knows the protocol says which line answers; a stop overtakes everything but a write."""

from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from threading import Lock, RLock
from typing import Final, Generic, TypeVar

from drivers.serial_line.port import BITS_PER_BYTE, SerialPort, port_gone, stopped_before
from protocols import Clock, DeviceTimeout

AnswerT = TypeVar("AnswerT")

_SHOWN: Final = 80
"""Bytes of what came instead of an answer that an error shows."""


@dataclass(frozen=True)
class Answer(Generic[AnswerT]):
    """An answer, and when it holds."""

    value: AnswerT

    time_s: float
    """The middle between question and answer, on the bench's clock."""


class LineWire:
    """A serial port on which lines end with LF, with CR before it or not."""

    def __init__(
        self, port: SerialPort, clock: Clock, *, device: str, baud: int, longest: int, margin_s: float, poll_s: float
    ) -> None:
        """Take over an open port.

        Args:
            port: at the right speed; reads never block.
            clock: every wait is on it.
            device: name that errors carry.
            baud: speed of the line.
            longest: bytes after which a line without LF is noise.
            margin_s: time that the device may think, beyond the time of the bytes on the line.
            poll_s: time between two looks at the port.
        """
        self.turn: Final = RLock()
        """Held by whoever asks and reads. A stop does not take it."""

        self.stops = 0
        """How many stops have been sent."""

        self.clock: Final = clock
        self.device: Final = device
        self._port = port
        self._byte_s = BITS_PER_BYTE / baud
        self._longest, self._margin_s, self._poll_s = longest, margin_s, poll_s
        self._write_lock = Lock()
        self._part = b""
        self._lines: deque[bytes] = deque()
        self._seen = b""

    def exchange(
        self,
        data: bytes,
        answers: Callable[[bytes], AnswerT | None],
        awaited: str,
        *,
        unless_stopped_since: int | None = None,
        limit_s: float | None = None,
    ) -> Answer[AnswerT]:
        """Send ``data`` and give what ``answers`` makes of the first line that is an answer.

        Args:
            data: bytes to send; none where the answer is under way already.
            answers: is given each line that comes, without its end; None: the line is no answer, and is dropped. It may raise.
            awaited: name of the answer, for errors.
            unless_stopped_since: send nothing where a stop was sent after this count of stops.
            limit_s: longest wait; None takes the time of the bytes on the line plus the margin.

        Raises:
            DeviceTimeout: no answer; names what was awaited and what came.
            DeviceError: a stop came first; nothing was sent.
            DeviceDisconnected: the port is gone.
        """
        with self.turn:
            self._seen = b""
            sent_s = self.clock.now_s()
            if data:
                self.put(data, unless_stopped_since=unless_stopped_since)
            line_s = (len(data) + self._longest) * self._byte_s
            deadline_s = sent_s + (line_s + self._margin_s if limit_s is None else limit_s)
            self.clock.sleep_s(len(data) * self._byte_s)  # before that, it does not even have the question
            while True:
                for line in self.lines():
                    value = answers(line)
                    if value is not None:
                        return Answer(value, (sent_s + self.clock.now_s()) / 2)
                if self.clock.now_s() >= deadline_s:
                    raise DeviceTimeout(
                        self.device,
                        awaited=f"{awaited} in answer to {data!r}",
                        waited_s=self.clock.now_s() - sent_s,
                        progress=f"only {self._seen[-_SHOWN:]!r}" if self._seen else "not a byte",
                        remedy="check the cable, the power, the speed of the line and the device's address",
                    )
                self.clock.sleep_s(self._poll_s)

    def lines(self) -> Iterator[bytes]:
        """Give the lines that have arrived by now, one after another; what is not taken stays."""
        data = self._read()
        self._seen = (self._seen + data)[-4 * self._longest :]
        *whole, self._part = (self._part + data).split(b"\n")
        if len(self._part) > self._longest:
            self._part = b""
        self._lines.extend(line.rstrip(b"\r") for line in whole)
        while self._lines:
            yield self._lines.popleft()

    def put(self, data: bytes, *, unless_stopped_since: int | None = None) -> None:
        """Write ``data``, unless a stop was sent after ``unless_stopped_since``.

        Raises:
            DeviceError: a stop came first; nothing was sent.
            DeviceDisconnected: the port is gone.
        """
        with self._write_lock:
            if unless_stopped_since is not None and self.stops != unless_stopped_since:
                raise stopped_before(self.device)
            self._put(data)

    def stop(self, data: bytes) -> None:
        """Write ``data``, which stops the device, whatever else is going on."""
        with self._write_lock:
            self.stops += 1
            self._put(data)

    def clear(self) -> None:
        """Throw away what has come so far."""
        with self.turn:
            self._port.reset_input_buffer()
            self._lines.clear()
            self._part = b""

    def close(self) -> None:
        """Give the port back."""
        self._port.close()

    def _read(self) -> bytes:
        try:
            waiting = self._port.in_waiting
            return self._port.read(waiting) if waiting else b""
        except OSError as error:
            raise port_gone(self.device, error) from error

    def _put(self, data: bytes) -> None:
        try:
            self._port.write(data)
        except OSError as error:
            raise port_gone(self.device, error) from error
