"""Faults of NI analogue inputs. The values are volts, so they are never those of a counted run."""

from typing import Any, Final

from protocols import CounterOverrun, DeviceBusy, DeviceDisconnected, DriverUnavailable, InputError
from tests.faults.row import Row


def _row(fault: str, emulator: str, **answers: object) -> Row:
    values: dict[str, Any] = {"fault": fault, "counter": "ni-analog", "emulator": emulator, **answers}
    return Row(**values)


ROWS: Final = (
    _row(
        "no such board",
        'device = "Dev2"',
        at_opening=True,
        error=DriverUnavailable,
        says=("pmt", "no such device"),
        kept=0,
    ),
    _row(
        "more samples a second than the board takes",
        "max_rate_hz = 500000",
        at_opening=True,
        error=InputError,
        says=("pmt", "at most 250000"),
        kept=0,
    ),
    _row(
        "another program holds the inputs",
        "reserved = true",
        error=DeviceBusy,
        says=("pmt", "another program holds"),
        kept=0,
    ),
    _row(
        "the board overwrites samples that were not read",
        "overrun_at_read = 0",
        error=CounterOverrun,
        says=("pmt",),
        kept=0,
    ),
    _row("the board is unplugged", "gone_at_read = 0", error=DeviceDisconnected, says=("pmt",), kept=0),
    _row(
        "the detector's voltage leaves the range in every frame",
        "volts_per_light = 0.5",
        says=("reached 99% of the range of 10 V",),
        verdict="flagged",
        masked="all",
    ),
)
