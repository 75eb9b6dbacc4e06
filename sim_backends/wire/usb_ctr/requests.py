"""What every group of vendor requests is made of."""

from collections.abc import Callable
from typing import TypeAlias

Write: TypeAlias = Callable[[int, int, bytes], None]
"""wValue, wIndex and the data of a transfer to the device."""

Read: TypeAlias = Callable[[int, int, int], bytes]
"""wValue, wIndex and wLength of a transfer from the device."""


class Stall(Exception):
    """The device refuses a control transfer."""


class TimedOut(Exception):
    """Nothing came in time."""


class Gone(Exception):
    """The device has left the bus."""


def exactly(data: bytes, size: int) -> bytes:
    """Give the data of a transfer that must have ``size`` bytes; stall otherwise."""
    if len(data) != size:
        raise Stall
    return data


def number(data: bytes, size: int) -> int:
    """A little-endian unsigned number of ``size`` bytes."""
    return int.from_bytes(exactly(data, size), "little")
