"""What bench.toml can tell the DLP7000 driver."""

from pathlib import Path
from typing import Literal

from pydantic import NonNegativeInt, PositiveInt

from protocols.values import Frozen


class Dlp7000Settings(Frozen):
    """Keys of ``[modulator]`` with ``driver = "dlp7000"``."""

    library: Path | None = None
    """The ALP library's file, relative to bench.toml; None looks in the vendor's usual places."""

    device_number: NonNegativeInt = 0
    """Serial number of the board; 0 takes the first one found."""

    sync_polarity: Literal["high", "low"] = "high"
    """Level of the sync output during its pulse."""

    trigger: Literal["master", "slave"] = "master"
    """Who gives the picture clock. Only ``master`` is driven: ``slave`` is refused with the reason."""

    flut: Literal["auto", "off", "required"] = "auto"
    """Frame look-up table. ``auto`` uses it where the play order fits, and uploads in play order where not; ``off`` always
    uploads in play order; ``required`` refuses what does not fit."""

    bit_order: Literal["msb-first", "lsb-first"] = "msb-first"
    """Bit of a byte that is the leftmost of its eight mirrors: the highest, by the vendor's header. A single lit
    column that moves in the wrong direction within eight columns calls for the other."""

    upload_batch: PositiveInt = 64
    """Planes handed over in one call: 64 are 6 MB. Progress is told, and a halt noticed, between batches."""

    after_halt: Literal["float", "hold"] = "float"
    """Mirrors after a halt in mid-run. A halted board is believed to hold its last picture, so ``float`` lets the mirrors go
    flat, which sends no light to either side; ``hold`` leaves them as the board does. Not yet seen on a bench."""

    accept_any_version: bool = False
    """Take a library whose version is not 4.x or 5.x. That the version's high byte is the major number is known from one
    laboratory's read-out only (0x0401 for ALP-4.1)."""
