"""The numbers of ``alp.h`` that the emulator knows (dlp7000.md 3.3 to 3.7)."""

from enum import IntEnum


class Code(IntEnum):
    """Return codes (dlp7000.md 3.3)."""

    OK = 0
    NOT_ONLINE = 1001
    NOT_IDLE = 1002
    NOT_AVAILABLE = 1003
    NOT_READY = 1004
    PARM_INVALID = 1005
    ADDR_INVALID = 1006
    MEMORY_FULL = 1007
    SEQ_IN_USE = 1008
    HALTED = 1009
    DEVICE_REMOVED = 1012
    CONFIG_MISMATCH = 1021
    ERROR_UNKNOWN = 1999


class State(IntEnum):
    """Device states (dlp7000.md 3.3)."""

    BUSY = 1100
    READY = 1101
    IDLE = 1102


class Dev(IntEnum):
    """Device controls and inquiries (dlp7000.md 3.4)."""

    NUMBER = 2000
    VERSION = 2001
    STATE = 2002
    AVAIL_MEMORY = 2003
    SYNCH_POLARITY = 2004
    TRIGGER_EDGE = 2005
    TRIGGER_TIME_OUT = 2014
    USB_CONNECTION = 2016
    DMDTYPE = 2021
    DYN_SYNCH_OUT1_GATE = 2023
    DYN_SYNCH_OUT2_GATE = 2024
    DYN_SYNCH_OUT3_GATE = 2025
    DDC_FPGA_TEMPERATURE = 2050
    APPS_FPGA_TEMPERATURE = 2051
    PCB_TEMPERATURE = 2052
    DISPLAY_HEIGHT = 2057
    DISPLAY_WIDTH = 2058
    GPIO5_PIN_MUX = 2062
    PWM_LEVEL = 2063
    DMD_MODE = 2064
    USB_DISCONNECT_BEHAVIOUR = 2078


class Seq(IntEnum):
    """Sequence controls and inquiries (dlp7000.md 3.5)."""

    REPEAT = 2100
    FIRSTFRAME = 2101
    LASTFRAME = 2102
    BITNUM = 2103
    BIN_MODE = 2104
    PWM_MODE = 2107
    DATA_FORMAT = 2110
    FLUT_MODE = 2118
    PUT_LOCK = 2119
    FLUT_ENTRIES9 = 2120
    FLUT_OFFSET9 = 2122
    DMD_LINES = 2125
    BITPLANES = 2200
    PICNUM = 2201
    PICTURE_TIME = 2203
    ILLUMINATE_TIME = 2204
    SYNCH_DELAY = 2205
    SYNCH_PULSEWIDTH = 2206
    TRIGGER_IN_DELAY = 2207
    MAX_SYNCH_DELAY = 2209
    MAX_TRIGGER_IN_DELAY = 2210
    MIN_PICTURE_TIME = 2211
    MIN_ILLUMINATE_TIME = 2212
    MAX_PICTURE_TIME = 2213
    ON_TIME = 2214
    OFF_TIME = 2215


class Proj(IntEnum):
    """Projection controls and inquiries (dlp7000.md 3.6)."""

    MODE = 2300
    INVERSION = 2306
    UPSIDE_DOWN = 2307
    QUEUE_MODE = 2314
    QUEUE_ID = 2315
    QUEUE_MAX_AVAIL = 2316
    QUEUE_AVAIL = 2317
    PROGRESS = 2318
    RESET_QUEUE = 2319
    ABORT_SEQUENCE = 2320
    ABORT_FRAME = 2321
    WAIT_UNTIL = 2323
    FLUT_MAX_ENTRIES9 = 2324
    FLUT_WRITE_9BIT = 2325
    FLUT_WRITE_18BIT = 2326
    STEP = 2329
    ABORT_ASYNC = 2345
    LEFT_RIGHT_FLIP = 2346
    STATE = 2400


FUNCTIONS = frozenset(
    f"Alp{name}"
    for name in [
        "DevAlloc",
        "DevHalt",
        "DevFree",
        "DevControl",
        "DevControlEx",
        "DevInquire",
        "SeqAlloc",
        "SeqFree",
        "SeqControl",
        "SeqTiming",
        "SeqInquire",
        "SeqPut",
        "SeqPutEx",
        "ProjStart",
        "ProjStartCont",
        "ProjHalt",
        "ProjWait",
        "ProjControl",
        "ProjControlEx",
        "ProjInquire",
        "ProjInquireEx",
    ]
)
"""Functions of dlp7000.md 3.2 that the emulator has. The LED functions are not there."""

INVALID_ID = 0xFFFFFFFF
LEVEL_HIGH, LEVEL_LOW = 2006, 2007
EDGE_FALLING, EDGE_RISING = 2008, 2009
BIN_NORMAL, BIN_UNINTERRUPTED = 2105, 2106
MASTER, SLAVE = 2301, 2302
SEQUENCE_QUEUE = 1
PROJ_ACTIVE, PROJ_IDLE = 1200, 1201
MSB_ALIGN, LSB_ALIGN, BINARY_TOPDOWN, BINARY_BOTTOMUP = 0, 1, 2, 3
FLUT_NONE, FLUT_9BIT, FLUT_18BIT = 0, 1, 2
DMD_POWER_FLOAT = 1
DMD_DISCONNECTED = 255


class Refused(Exception):
    """A call that the library answers with a return code other than 0."""

    def __init__(self, code: int) -> None:
        """Keep the code."""
        super().__init__(code)
        self.code = code


def require(condition: bool, code: int = Code.PARM_INVALID) -> None:  # noqa: FBT001
    """Refuse the call unless ``condition`` holds."""
    if not condition:
        raise Refused(code)
