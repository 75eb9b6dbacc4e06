"""Numbers of the ALP-4 C interface, by the names of the vendor's header (fact sheet dlp7000, 3.1 and 3.3 to 3.6).

Only what the driver uses. Beware of the header's older names: there TRIGGER is the *output* and VD the input; here, as in
the newer headers, SYNCH is the output and TRIGGER the input.
"""

from enum import IntEnum

DEFAULT = 0
"""ALP_DEFAULT: the library's own choice."""

INVALID_ID = 0xFFFFFFFF
"""ALP_INVALID_ID: never a valid device or sequence."""


class ReturnCode(IntEnum):
    """What every function of the library returns."""

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
    ERROR_INIT = 1010
    ERROR_COMM = 1011
    DEVICE_REMOVED = 1012
    NOT_CONFIGURED = 1013
    LOADER_VERSION = 1014
    ERROR_POWER_DOWN = 1018
    DRIVER_VERSION = 1019
    SDRAM_INIT = 1020
    CONFIG_MISMATCH = 1021
    ERROR_UNKNOWN = 1999


class DeviceInquiry(IntEnum):
    """What ``AlpDevInquire`` can be asked."""

    DEVICE_NUMBER = 2000
    VERSION = 2001
    AVAIL_MEMORY = 2003
    DMD_TYPE = 2021
    DISPLAY_HEIGHT = 2057
    DISPLAY_WIDTH = 2058


class DeviceControl(IntEnum):
    """What ``AlpDevControl`` can set."""

    SYNCH_POLARITY = 2004
    DMD_MODE = 2064


class SynchPolarity(IntEnum):
    """Level of the sync **output** during its pulse."""

    LEVEL_HIGH = 2006
    LEVEL_LOW = 2007


class DmdMode(IntEnum):
    """Mirrors at work, or let go to lie flat at about 0 degrees."""

    RESUME = 0
    POWER_FLOAT = 1


class DmdType(IntEnum):
    """The mirror array that the board found."""

    XGA = 1
    SXGA_PLUS = 2
    DLP9500 = 3
    DLP7000 = 4
    XGA_055A = 5
    XGA_055X = 6
    WUXGA_096A = 7
    DLP9000X_400MHZ = 8
    DLP9000X_480MHZ = 9
    HD_065A = 10
    HD_065_S600 = 11
    DLP650LNIR = 12
    DLPC910REV = 254
    DISCONNECTED = 255


class SequenceControl(IntEnum):
    """What ``AlpSeqControl`` can set."""

    REPEAT = 2100
    BITNUM = 2103
    BIN_MODE = 2104
    DATA_FORMAT = 2110
    FLUT_MODE = 2118
    FLUT_ENTRIES9 = 2120
    FLUT_OFFSET9 = 2122


class SequenceInquiry(IntEnum):
    """What ``AlpSeqInquire`` can be asked; all times in whole microseconds."""

    PICTURE_TIME = 2203
    SYNCH_DELAY = 2205
    SYNCH_PULSEWIDTH = 2206
    MAX_SYNCH_DELAY = 2209
    MIN_PICTURE_TIME = 2211
    MAX_PICTURE_TIME = 2213


class BinaryMode(IntEnum):
    """Whether one-bit pictures follow each other with or without a dark phase."""

    NORMAL = 2105
    UNINTERRUPTED = 2106


class DataFormat(IntEnum):
    """Layout of the image data: here 8 mirrors a byte, top row first."""

    BINARY_TOPDOWN = 2


class FlutMode(IntEnum):
    """How a sequence uses the frame look-up table (FLUT)."""

    NONE = 0
    BITS_9 = 1
    BITS_18 = 2


class ProjectionControl(IntEnum):
    """What ``AlpProjControl`` and ``AlpProjControlEx`` can set."""

    PROJ_MODE = 2300
    FLUT_WRITE_9BIT = 2325
    FLUT_WRITE_18BIT = 2326


class ProjectionInquiry(IntEnum):
    """What ``AlpProjInquire`` and ``AlpProjInquireEx`` can be asked."""

    PROGRESS = 2318
    FLUT_MAX_ENTRIES9 = 2324
    PROJ_STATE = 2400


class ProjectionMode(IntEnum):
    """Who gives the picture clock."""

    MASTER = 2301
    SLAVE = 2302


class ProjectionState(IntEnum):
    """Whether pictures are being played."""

    ACTIVE = 1200
    IDLE = 1201
