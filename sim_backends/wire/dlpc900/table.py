"""Definitions of patterns: what is shown, for how long (sheet, section 3.3)."""

import struct
from dataclasses import dataclass


@dataclass(frozen=True)
class Definition:
    """One entry of the look-up table."""

    exposure_us: int
    dark_us: int
    image: int
    bit: int
    edge: bool
    """Whether TRIG_OUT2 gives a pulse."""


def define(data: bytes, shortest_us: int) -> tuple[int, Definition] | int:
    """Give number and definition of what a command says, or the number of an error."""
    if len(data) != 12:
        return 6
    (number,) = struct.unpack("<H", data[:2])
    exposure_us = int.from_bytes(data[2:5], "little")
    dark_us = int.from_bytes(data[6:9], "little")
    (place,) = struct.unpack("<H", data[10:])
    image, bit = place & 0x7FF, place >> 11
    if number > 511:
        return 15
    if data[5] >> 1 & 7:
        return 16  # more than one bit is not emulated
    if exposure_us < shortest_us:
        return 14
    if bit > 23:
        return 10
    if image > 17:
        return 17
    return number, Definition(exposure_us, dark_us, image, bit, edge=not data[9] & 1)
