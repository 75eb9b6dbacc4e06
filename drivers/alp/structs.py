"""The two C structures that the driver passes to the ALP library: packed without gaps, 32-bit members (fact sheet 3.7)."""

import ctypes
from typing import ClassVar

FLUT_WRITE_ENTRIES = 4096
"""Entries that one ``tFlutWrite`` can carry."""


class FlutWrite(ctypes.Structure):
    """``tFlutWrite``: a run of entries of the frame look-up table, counted in entries of the width being written."""

    _pack_ = 1
    _fields_: ClassVar = [
        ("nOffset", ctypes.c_int32),
        ("nSize", ctypes.c_int32),
        ("FrameNumbers", ctypes.c_uint32 * FLUT_WRITE_ENTRIES),
    ]
    nOffset: int  # noqa: N815
    nSize: int  # noqa: N815
    FrameNumbers: "ctypes.Array[ctypes.c_uint32]"


class ProjectionProgress(ctypes.Structure):
    """``tAlpProjProgress``: how far the display has come. Its counters count down."""

    _pack_ = 1
    _fields_: ClassVar = [
        ("CurrentQueueId", ctypes.c_uint32),
        ("SequenceId", ctypes.c_uint32),
        ("nWaitingSequences", ctypes.c_uint32),
        ("nSequenceCounter", ctypes.c_uint32),
        ("nSequenceCounterUnderflow", ctypes.c_uint32),
        ("nFrameCounter", ctypes.c_uint32),
        ("nPictureTime", ctypes.c_uint32),
        ("nFramesPerSubSequence", ctypes.c_uint32),
        ("nFlags", ctypes.c_uint32),
    ]
    nFrameCounter: int  # noqa: N815
