"""What bench.toml can tell the driver."""

from pydantic import Field, NonNegativeFloat, PositiveFloat, PositiveInt

from drivers.h10682.detector import Head
from protocols import Frozen


class SerialCounterSettings(Frozen):
    """The ``[counter]`` table for ``driver = "serial-counter"``."""

    port: str = ""
    """Serial port (``COM3``, ``/dev/ttyACM0``) or pyserial URL. May be left out where bench.toml names a transport."""

    baud: PositiveInt = 115_200
    """Speed of the line; over USB it means nothing."""

    max_sync_rate_hz: PositiveFloat = 5_000.0
    """Highest rate of sync edges that counter and line carry, as measured; 500 at 115200 baud."""

    counter_dead_time_s: NonNegativeFloat = 35e-9
    """Pulse pairs that the counter merges [I]: four cycles of a Pico's 125 MHz, and the width of a pulse."""

    reply_margin_s: PositiveFloat = 0.5
    """Time that the counter may think about an answer, beyond the time of the bytes on the line, in seconds."""

    poll_s: PositiveFloat = 0.001
    """Time between two looks at the port while an answer is awaited, in seconds."""

    head: Head = Field(default_factory=Head)
    """Detector at the counter's input."""
