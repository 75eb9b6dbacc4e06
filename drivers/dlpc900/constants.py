"""Commands, models and errors of the DLPC900 (TI DLPU018F, by the fact sheet; section numbers are the sheet's)."""

from collections.abc import Mapping
from dataclasses import dataclass
from types import MappingProxyType
from typing import Final

VENDOR_ID, PRODUCT_ID = 0x0451, 0xC900

LAST_ERROR: Final = 0x0100
ERROR_TEXT: Final = 0x0101
VERSION: Final = 0x0205
HARDWARE: Final = 0x0206
HARDWARE_STATUS: Final = 0x1A0A
SYSTEM_STATUS: Final = 0x1A0B
MAIN_STATUS: Final = 0x1A0C
DISPLAY_MODE: Final = 0x1A1B
TRIGGER_OUT_2: Final = 0x1A1E
SEQUENCE: Final = 0x1A24
LOAD_BEGIN: Final = (0x1A2A, 0x1A2C)
"""Primary and secondary controller."""

LOAD_DATA: Final = (0x1A2B, 0x1A2D)
LUT_CONFIGURE: Final = 0x1A31
LUT_DEFINE: Final = 0x1A34

ON_THE_FLY: Final = 3
STOP, START = 0, 2
RUNNING: Final = 1 << 1
"""Bit of the main status."""

PATTERNS: Final = 400
"""One-bit patterns that the memory holds, and entries of the look-up table by the guide's text (the field says 512)."""

PATTERNS_PER_IMAGE: Final = 24
DATA_BYTES: Final = 504
"""Of one packet of an image (section 4)."""

TRIGGER_WIDTH_US: Final = 20
"""Shortest pulse of TRIG_OUT2 that the guide speaks of."""

LONGEST_US: Final = 2**24 - 1
"""Exposure has 24 bits."""


@dataclass(frozen=True)
class Mirrors:
    """A mirror array behind the controller."""

    name: str
    columns: int
    rows: int
    shortest_us: int
    """Shortest exposure of a one-bit pattern, in microseconds (section 5.1)."""

    controllers: int
    """1, or 2 where each has one half of the columns."""


MODELS: Final[Mapping[int, Mirrors]] = MappingProxyType(
    {
        1: Mirrors("DLP6500", 1920, 1080, 105, 1),
        2: Mirrors("DLP9000", 2560, 1600, 105, 2),
    }
)
"""By the answer to ``HARDWARE``. DLP670S (3) and DLP500YX (4) are not here: how their halves are loaded is in no source read."""

ERRORS: Final[Mapping[int, str]] = MappingProxyType(
    {
        1: "batch file checksum",
        2: "device failure",
        3: "invalid command number",
        4: "incompatible controller and DMD",
        5: "not allowed in the present mode",
        6: "invalid parameter",
        7: "an item that is not present",
        8: "out of memory",
        9: "invalid compression",
        10: "bit number out of range",
        11: "image not in flash",
        12: "dark time out of range",
        13: "trigger delay out of range",
        14: "exposure out of range",
        15: "pattern number out of range",
        16: "invalid pattern definition",
        17: "image address out of range",
        255: "internal error",
    }
)

TROUBLES: Final[Mapping[int, str]] = MappingProxyType(
    {
        1: "controller and DMD, or its firmware, do not fit",
        2: "reset controller error",
        3: "forced swap error",
        6: "sequencer abort",
        7: "sequencer error",
    }
)
"""Bits of the hardware status that should be 0."""
