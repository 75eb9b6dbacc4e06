"""What goes into the board's memory, and how it is put into play order.

With the frame look-up table (FLUT) each unique plane is stored once and the table gives the order: 9-bit entries where 512
planes are enough, else 18-bit entries, which take two 9-bit places each. The library does not reject a table that overflows,
so the driver does. Without a table that is long enough the planes are stored once for each picture, in play order.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from drivers.alp.constants import FlutMode
from protocols.errors import PatternMemoryFull
from protocols.modulator import PatternSequence
from protocols.values import Bytes, Integers

_REVERSED: Final = np.packbits(np.unpackbits(np.arange(256, dtype=np.uint8)).reshape(256, 8)[:, ::-1], axis=-1).ravel()
"""Each byte with its bits in the opposite order."""


@dataclass(frozen=True, eq=False)
class Upload:
    """The memory image of a sequence."""

    planes: Integers
    """``(stored,)`` index of the plane that lies at each place of the board's memory."""

    mode: FlutMode
    """Width of the table's entries; ``NONE`` plays the memory from its first place to its last."""

    entries: Integers
    """``(pictures,)`` place of each picture, in play order; empty with ``NONE``."""

    @property
    def entries9(self) -> int:
        """Length of the table in 9-bit entries, as ALP_FLUT_ENTRIES9 counts them."""
        return len(self.entries) * (2 if self.mode is FlutMode.BITS_18 else 1)

    def distinct(self, stored: int) -> int:
        """Unique planes among the first ``stored`` places."""
        return len(np.unique(self.planes[:stored]))


def plan_upload(
    sequence: PatternSequence,
    *,
    memory: int,
    table_entries9: int,
    flut: Literal["auto", "off", "required"],
    device: str,
) -> Upload:
    """Choose how ``sequence`` is stored.

    Args:
        sequence: what to store.
        memory: one-bit planes that the board can hold.
        table_entries9: length of the board's table in 9-bit entries; 0 where it has none.
        flut: the setting of the same name.
        device: name for errors.

    Raises:
        PatternMemoryFull: it does not fit; names what, how much, and how much would.
    """
    unique, pictures = len(sequence.planes), len(sequence.play_order)
    mode = FlutMode.NONE if flut == "off" else _table_mode(unique, pictures, table_entries9)
    if mode is not FlutMode.NONE:
        if unique > memory:
            raise PatternMemoryFull(device, unique, memory)
        return Upload(np.arange(unique), mode, sequence.play_order)
    if flut == "required":
        width = 1 if unique <= 512 else 2
        raise PatternMemoryFull(device, pictures, table_entries9 // width, "pictures for the frame look-up table")
    if pictures > memory:
        why = "off" if flut == "off" else f"{table_entries9} 9-bit entries: too short"
        raise PatternMemoryFull(
            device, pictures, memory, f"pictures to be stored in play order (frame look-up table: {why})"
        )
    return Upload(sequence.play_order, FlutMode.NONE, np.empty(0, np.int64))


def _table_mode(unique: int, pictures: int, table_entries9: int) -> FlutMode:
    if unique <= 2**9 and pictures <= table_entries9:
        return FlutMode.BITS_9
    if unique <= 2**18 and 2 * pictures <= table_entries9:
        return FlutMode.BITS_18
    return FlutMode.NONE


def batches(
    sequence: PatternSequence, upload: Upload, size: int, bit_order: Literal["msb-first", "lsb-first"]
) -> Iterator[tuple[int, Bytes]]:
    """Give (place, ``(n, rows, columns / 8)`` planes as mirrors) until all is given, ``size`` planes at a time."""
    for first in range(0, len(upload.planes), size):
        distinct, where = np.unique(upload.planes[first : first + size], return_inverse=True)
        mirrors = np.stack([sequence.mirror_plane(int(plane)) for plane in distinct])[where]
        yield first, mirrors if bit_order == "msb-first" else _REVERSED[mirrors]
