"""The seam between driver and vendor library: the table of C functions that the driver calls.

Whatever the driver talks through (``BenchContext.transport``, or the vendor library itself) is one object with the functions
below as attributes, under their C names and with the C order of arguments (fact sheet 3.2). A ``ctypes.CDLL`` of the library
is such an object; an emulator or a recorder is any other. The driver keeps to these rules, and expects them:

* every function returns the library's code as a Python ``int``, 0 for success; it does not raise;
* every integer argument is a ``ctypes.c_int32``, or a ``ctypes.c_uint32`` for a device or sequence id: an object with
  ``.value``. Never ``c_long``, whose size changes with the platform;
* every out-parameter is ``ctypes.byref`` of a ``c_uint32`` (ids) or ``c_int32`` (inquiries), every structure ``ctypes.byref``
  of the structure. Python code reaches the object behind it as ``pointer._obj``, or by ``ctypes.cast`` to a typed pointer;
* image data is a ``ctypes.c_void_p``: the address of the first byte, valid during the call only. ``AlpSeqPut`` reads
  ``PicLoad`` pictures of 98,304 bytes (128 bytes a row, 768 rows, top row first) in the format BINARY_TOPDOWN;
* any function may be called from any thread. ``AlpDevHalt`` may come while another thread is inside ``AlpSeqPut``, which
  then returns 1009. All other calls are made one at a time.
"""

import ctypes
from typing import Any, Protocol, TypeAlias

Int: TypeAlias = ctypes.c_int32
"""C ``long`` of the header: 32 bits on every platform."""

Id: TypeAlias = ctypes.c_uint32
"""``ALP_ID``: 32 bits, unsigned, on every platform."""

Pointer: TypeAlias = Any
"""``ctypes.byref(...)`` of what the function reads or fills; ctypes has no public name for its type."""


class AlpApi(Protocol):
    """The C functions that the driver uses, no more."""

    def AlpDevAlloc(self, device_number: Int, init_flag: Int, device_id: Pointer, /) -> int:  # noqa: N802
        """Take a board, by serial number or (0) the first one found; fills the device id."""
        ...

    def AlpDevHalt(self, device: Id, /) -> int:  # noqa: N802
        """Stop display and upload; the board is idle afterwards."""
        ...

    def AlpDevFree(self, device: Id, /) -> int:  # noqa: N802
        """Let go of an idle board and of all its sequences."""
        ...

    def AlpDevControl(self, device: Id, control: Int, value: Int, /) -> int:  # noqa: N802
        """Set a ``DeviceControl``."""
        ...

    def AlpDevInquire(self, device: Id, inquiry: Int, value: Pointer, /) -> int:  # noqa: N802
        """Ask a ``DeviceInquiry``; fills the value."""
        ...

    def AlpSeqAlloc(self, device: Id, bit_planes: Int, pictures: Int, sequence_id: Pointer, /) -> int:  # noqa: N802
        """Reserve memory for pictures; fills the sequence id."""
        ...

    def AlpSeqFree(self, device: Id, sequence: Id, /) -> int:  # noqa: N802
        """Give a sequence's memory back."""
        ...

    def AlpSeqControl(self, device: Id, sequence: Id, control: Int, value: Int, /) -> int:  # noqa: N802
        """Set a ``SequenceControl``."""
        ...

    def AlpSeqTiming(  # noqa: N802, PLR0917
        self,
        device: Id,
        sequence: Id,
        illuminate_us: Int,
        picture_us: Int,
        synch_delay_us: Int,
        synch_width_us: Int,
        trigger_in_delay_us: Int,
        /,
    ) -> int:
        """Set a sequence's times; 0 takes the default."""
        ...

    def AlpSeqInquire(self, device: Id, sequence: Id, inquiry: Int, value: Pointer, /) -> int:  # noqa: N802
        """Ask a ``SequenceInquiry``; fills the value."""
        ...

    def AlpSeqPut(self, device: Id, sequence: Id, first: Int, pictures: Int, data: ctypes.c_void_p, /) -> int:  # noqa: N802
        """Upload pictures; blocks until they are stored."""
        ...

    def AlpProjStart(self, device: Id, sequence: Id, /) -> int:  # noqa: N802
        """Play a sequence ``REPEAT`` times; returns at once."""
        ...

    def AlpProjControl(self, device: Id, control: Int, value: Int, /) -> int:  # noqa: N802
        """Set a ``ProjectionControl``."""
        ...

    def AlpProjControlEx(self, device: Id, control: Int, structure: Pointer, /) -> int:  # noqa: N802
        """Set a ``ProjectionControl`` that takes a structure (``tFlutWrite``)."""
        ...

    def AlpProjInquire(self, device: Id, inquiry: Int, value: Pointer, /) -> int:  # noqa: N802
        """Ask a ``ProjectionInquiry``; fills the value. There is no sequence among the arguments."""
        ...

    def AlpProjInquireEx(self, device: Id, inquiry: Int, structure: Pointer, /) -> int:  # noqa: N802
        """Ask a ``ProjectionInquiry`` that fills a structure (``tAlpProjProgress``)."""
        ...
