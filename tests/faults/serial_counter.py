"""Faults of the serial counter and of its line."""

from typing import Any, Final

from protocols import CounterOverrun, DeviceDisconnected, DeviceTimeout, DriverUnavailable
from tests.faults.row import Row


def _row(fault: str, line: str, **answers: object) -> Row:
    values: dict[str, Any] = {
        "fault": fault,
        "counter": "serial-counter",
        "emulator": f"faults = [{{ {line} }}]",
        **answers,
    }
    return Row(**values)


ROWS: Final = (
    _row("mute from the start", 'kind = "mute"', at_opening=True, error=DriverUnavailable, says=("pmt",), kept=0),
    _row(
        "the line of a bin is lost",
        'kind = "lost-line", bin = 100',
        error=CounterOverrun,
        says=("pmt", "bin 101 where bin 100 comes next, 0 damaged lines"),
        kept=100,
        verdict="partial",
    ),
    _row(
        "the line of a bin is damaged",
        'kind = "corrupted-line", bin = 100',
        error=CounterOverrun,
        says=("pmt", "bin 101 where bin 100 comes next, 1 damaged lines"),
        kept=100,
        verdict="partial",
    ),
    _row(
        "the line is too slow, and the counter's memory fills",
        "",
        emulator="memory_bytes = 160\nbaud = 115200",
        error=CounterOverrun,
        says=("pmt", "no room in the counter's memory"),
        kept=13,
        verdict="partial",
    ),
    _row(
        "the counter is unplugged, and what the host had not read yet is gone",
        'kind = "unplugged", bin = 100',
        error=DeviceDisconnected,
        says=("pmt", "a serial port that fails"),
        kept=0,
        again=DeviceDisconnected,
    ),
    _row(
        "mute when it is to arm",
        'kind = "mute", nth = 3',
        error=DeviceTimeout,
        says=("pmt", "not a byte", "armed"),
        kept=0,
        again="as before",
    ),
    _row(
        "mute when it is to stop",
        'kind = "mute", nth = 4',
        says=("surplus sync edges are unknown",),
        again=DeviceTimeout,
    ),
)
