"""The frame look-up table: which picture comes when, without a second upload (dlp7000.md 3.5 to 3.7)."""

import ctypes
from collections.abc import Sequence

import numpy as np

from protocols import Integers
from sim_backends.wire.alp.codes import FLUT_18BIT, Code, Proj, require
from sim_backends.wire.alp.settings import AlpEmulatorSettings

_ARRAY = 4096
"""Entries that one tFlutWrite carries."""


class FrameTable:
    """One table of 9-bit slots a board; an 18-bit entry takes two, so its index is half of the 9-bit one."""

    def __init__(self, settings: AlpEmulatorSettings) -> None:
        """Begin with every entry at picture 0."""
        self._settings = settings
        self._slots = np.zeros(settings.flut_max_entries9, np.int64)

    @property
    def slots(self) -> int:
        """ALP_FLUT_MAX_ENTRIES9."""
        return len(self._slots)

    def accepts(self, mode: int) -> bool:
        """Whether this board can play by ALP_FLUT_MODE ``mode``."""
        return mode == 0 or (self.slots > 0 and (mode == 1 or (mode == FLUT_18BIT and self._settings.flut_18bit)))

    def write_struct(self, control: int, address: int) -> None:
        """Take a ``tFlutWrite`` (pack 1) from the caller's memory."""
        wide = control == Proj.FLUT_WRITE_18BIT
        require(self.accepts(FLUT_18BIT if wide else 1))
        require(address != 0, Code.ADDR_INVALID)
        offset, size = (ctypes.c_int32 * 2).from_address(address)
        require(0 <= size <= _ARRAY and (size > 0 or offset == 0))
        unit = 2 if wide else 1
        size = size or min(_ARRAY, self.slots // unit)
        frames = np.array((ctypes.c_uint32 * size).from_address(address + 8), np.int64)
        first = offset * (1 if self._settings.flut_write_unit == "slots9" else unit)
        require(first >= 0 and first + unit * size <= self.slots)
        self._slots[first : first + unit * size : unit] = frames & 0x1FF
        if wide:
            self._slots[first + 1 : first + unit * size : unit] = frames >> 9 & 0x1FF

    def order(self, mode: int, offset9: int, entries9: int) -> Integers:
        """Pictures in play order, ``(entries,)``."""
        slots = self._slots[offset9 : offset9 + entries9]
        if mode == FLUT_18BIT:
            even = slots[: len(slots) // 2 * 2]
            return even[0::2] | even[1::2] << 9
        return slots.copy()


def within(order: Integers, pictures: int, planes_a_picture: int) -> Integers:
    """Planes of a play order; an entry beyond the sequence, which the board does not reject, is -1 (dark)."""
    return np.where(order < pictures, order * planes_a_picture, -1)


def repeat(order: Integers, times: int, most: int) -> Integers:
    """Repeat an order ``times`` times, but lay out no more than ``most`` pictures beyond its own length."""
    whole = max(1, min(times, most // max(1, len(order))))
    return np.tile(order, whole)


def hold(order: Integers, lost: Sequence[int]) -> Integers:
    """Leave the picture before in the place of each lost one; before the first picture it is dark."""
    held = order.copy()
    for place in sorted(set(lost)):
        held[place] = held[place - 1] if place else -1
    return held
