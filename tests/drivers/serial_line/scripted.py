"""A serial port that plays a transcript: so many bytes sent, so many answered, nothing left over; and its virtual clock."""

from collections.abc import Callable, Sequence
from typing import TypeAlias

Line: TypeAlias = tuple[bytes, *tuple[bytes, ...]]
"""Bytes sent, then what is answered."""


class Clock:
    """Time that passes only where somebody waits."""

    def __init__(self) -> None:
        self.time_s = 0.0
        self.meanwhile: Callable[[], None] | None = None
        """What happens during the next wait."""

    def now_s(self) -> float:
        """Seconds since construction."""
        return self.time_s

    def sleep_s(self, duration_s: float) -> None:
        """Let time pass at once."""
        self.time_s += max(0.0, duration_s)
        meanwhile, self.meanwhile = self.meanwhile, None
        if meanwhile is not None:
            meanwhile()


class Port:
    """Answers each command of a transcript at once, in order, and fails at any other byte."""

    def __init__(self, transcript: Sequence[Line] = ()) -> None:
        self.timeout: float | None = None
        self.closed = False
        self.broken = False
        self.script = list(transcript)
        self._come = b""

    def expect(self, *lines: Line) -> None:
        """Append to the transcript."""
        self.script += lines

    def say(self, data: bytes) -> None:
        """Let bytes arrive that nobody asked for."""
        self._come += data

    @property
    def in_waiting(self) -> int:
        """Bytes that have arrived."""
        if self.broken:
            raise OSError("device reports readiness to read but returned no data")
        return len(self._come)

    def read(self, size: int = 1, /) -> bytes:
        """Take what has arrived."""
        data, self._come = self._come[:size], self._come[size:]
        return data

    def write(self, b: bytes, /) -> int:
        """Check the command against the transcript."""
        if self.broken:
            raise OSError("write failed: Input/output error")
        assert self.script, f"unexpected {b!r} at the end of the transcript"
        expected, *answers = self.script.pop(0)
        assert b == expected
        self._come += b"".join(answers)
        return len(b)

    def reset_input_buffer(self) -> None:
        """Forget what has arrived."""
        self._come = b""

    def close(self) -> None:
        """Close."""
        self.closed = True
