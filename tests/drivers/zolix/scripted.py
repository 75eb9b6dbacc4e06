"""A virtual clock, and a serial port that plays a transcript: so many bytes sent, so many answered, nothing left over."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from drivers.zolix.driver import Ka400z
from drivers.zolix.settings import Ka400zSettings
from protocols import BenchContext, MotionProfile

PROFILE = MotionProfile(velocity_mm_s=25, acceleration_mm_s2=50)
"""The fact sheet's example, section 5.1."""


class VirtualClock:
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


@dataclass(frozen=True)
class After:
    """Bytes that come ``delay_s`` after the command."""

    delay_s: float
    data: bytes


Answer: TypeAlias = bytes | After
Line: TypeAlias = tuple[bytes, *tuple[Answer, ...]]
"""Bytes sent, then what is answered."""


class ScriptedPort:
    """Answers each command of a transcript, in order, and fails at once at any other byte."""

    def __init__(self, clock: VirtualClock, transcript: Sequence[Line], answer_s: float = 0.01) -> None:
        self.timeout: float | None = None
        self.closed = False
        self.broken = False
        self._clock = clock
        self._answer_s = answer_s
        self._script = list(transcript)
        self._coming: list[tuple[float, bytes]] = []

    def expect(self, *lines: Line) -> None:
        """Append to the transcript."""
        self._script += lines

    def say(self, data: bytes) -> None:
        """Let bytes arrive that nobody asked for."""
        self._coming.append((self._clock.time_s, data))

    @property
    def lines_left(self) -> list[Line]:
        """What of the transcript is still to come."""
        return self._script

    def nothing_left_over(self) -> bool:
        """Whether every line of the transcript was played."""
        assert self._script == []
        return True

    @property
    def in_waiting(self) -> int:
        """Bytes that have arrived."""
        if self.broken:
            raise OSError("device reports readiness to read but returned no data")
        return sum(len(data) for at_s, data in self._coming if at_s <= self._clock.time_s)

    def read(self, size: int = 1, /) -> bytes:
        """Take what has arrived."""
        arrived = b"".join(data for at_s, data in self._coming if at_s <= self._clock.time_s)
        later = [(at_s, data) for at_s, data in self._coming if at_s > self._clock.time_s]
        self._coming = [(self._clock.time_s, arrived[size:]), *later]
        return arrived[:size]

    def write(self, b: bytes, /) -> int:
        """Check the command against the transcript."""
        if self.broken:
            raise OSError("write failed: Input/output error")
        assert self._script, f"unexpected {b!r} at the end of the transcript"
        expected, *answers = self._script.pop(0)
        assert b == expected
        for answer in answers:
            after = answer if isinstance(answer, After) else After(self._answer_s, answer)
            self._coming.append((self._clock.time_s + after.delay_s, after.data))
        self._coming.sort(key=lambda item: item[0])
        return len(b)

    def reset_input_buffer(self) -> None:
        """Forget what has arrived."""
        self._coming = []

    def close(self) -> None:
        """Close."""
        self.closed = True


def settings(**changes: object) -> Ka400zSettings:
    """400 pulses a millimetre: lead 4 mm, 8 microsteps, 200 full steps."""
    values: dict[str, object] = {
        "lead_mm": 4.0,
        "microsteps": 8,
        "travel_mm": (0.0, 400.0),
        "max_velocity_mm_s": 40.0,
        "max_acceleration_mm_s2": 100.0,
        "home_velocity_mm_s": 5.0,
    }
    return Ka400zSettings.model_validate({**values, **changes})


MC600_OPENS: tuple[Line, ...] = (
    (b"VE\r", b"E01\r"),
    (b"Hello\r", b"OK\r"),
    (b"Position? X\r", b"POSITION? X,12.345,OK\r"),
    (b"SetUnit? X\r", b"SETUNIT? X,m,OK\r"),
    (b"SetUnit X,s\r", b"OK\r"),
    (b"Position? X\r", b"POSITION? X,0.0,OK\r"),
    (b"Position? X\r", b"POSITION? X,0.0,OK\r"),
)

SC300_OPENS: tuple[Line, ...] = (
    (b"VE\r", b"SC300_V1.0\r"),
    (b"VE\r", b"SC300_V1.0\r"),
    (b"?X\r", b"?X,0\r"),
    (b"?X\r", b"?X,0\r"),
)


def opened(transcript: Sequence[Line], **changes: object) -> tuple[Ka400z, ScriptedPort, VirtualClock]:
    """Give a stage opened on ``transcript``, its port and its clock."""
    clock = VirtualClock()
    port = ScriptedPort(clock, transcript)
    return Ka400z(settings(**changes), BenchContext(clock=clock, transport=port)), port, clock
