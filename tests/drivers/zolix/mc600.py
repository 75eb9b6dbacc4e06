"""A stage on an MC600 that has been opened, and lines that many transcripts share."""

from drivers.zolix.driver import Ka400z
from tests.drivers.zolix.scripted import MC600_OPENS, Line, ScriptedPort, VirtualClock, opened

AT_ZERO: Line = (b"Position? X\r", b"POSITION? X,0.0,OK\r")


SPEEDS: tuple[Line, ...] = (
    (b"SetAccSpeed X,20000\r", b"OK\r"),
    (b"SetInitSpeed X,0\r", b"OK\r"),
    (b"SetSpeed X,10000\r", b"OK\r"),
)


def stage_on(*lines: Line, **changes: object) -> tuple[Ka400z, ScriptedPort, VirtualClock]:
    """Give a stage that has been opened and then plays ``lines``."""
    stage, port, clock = opened(MC600_OPENS, **changes)
    assert port.nothing_left_over()
    port.expect(*lines)
    return stage, port, clock
