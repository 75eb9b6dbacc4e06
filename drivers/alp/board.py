"""One allocated ALP board: the C calls as Python calls that take numbers, give numbers and raise typed errors."""

import ctypes
from threading import Lock
from typing import Final

import numpy as np

from drivers.alp.api import AlpApi, Id, Int
from drivers.alp.constants import (
    DEFAULT,
    INVALID_ID,
    DeviceControl,
    DeviceInquiry,
    FlutMode,
    ProjectionControl,
    ProjectionInquiry,
    ProjectionState,
    ReturnCode,
    SequenceControl,
    SequenceInquiry,
)
from drivers.alp.errors import error_of
from drivers.alp.structs import FLUT_WRITE_ENTRIES, FlutWrite, ProjectionProgress
from protocols.clock import Clock
from protocols.errors import PatternMemoryFull, ProtocolViolation
from protocols.values import Bytes, Integers

ALLOCATION_S: Final = 2.0
"""Time for which a board that says that it is not there is asked again."""

ALLOCATION_PAUSES: Final = 8
"""Pauses between these questions."""

_NOT_YET: Final = (ReturnCode.NOT_ONLINE, ReturnCode.ERROR_COMM, ReturnCode.DEVICE_REMOVED)


class AlpBoard:
    """A board, held from construction until ``free``.

    Every method raises the error of ``errors.error_of`` for the code that the library gives. Calls are made one at a time,
    but ``put`` holds no lock, so that ``halt`` reaches the library during an upload.
    """

    def __init__(self, api: AlpApi, device_number: int, name: str, clock: Clock | None = None) -> None:
        """Take the board with this serial number, or the first one found (0).

        A board that was let go of a moment ago may say that it is not there (1001, 1011 and 1012 were seen), so these
        answers are asked again for ``ALLOCATION_S`` on ``clock``; without a clock the first answer counts.
        """
        self.name = name
        self._api = api
        self._lock = Lock()
        handle = Id(INVALID_ID)
        code, pauses = api.AlpDevAlloc(Int(device_number), Int(DEFAULT), ctypes.byref(handle)), 0
        while code in _NOT_YET and clock is not None and pauses < ALLOCATION_PAUSES:
            clock.sleep_s(ALLOCATION_S / ALLOCATION_PAUSES)
            code, pauses = api.AlpDevAlloc(Int(device_number), Int(DEFAULT), ctypes.byref(handle)), pauses + 1
        self._check("AlpDevAlloc", code)
        self._id = self._valid("device", handle.value)

    def halt(self) -> None:
        """Stop display and upload."""
        with self._lock:
            self._check("AlpDevHalt", self._api.AlpDevHalt(Id(self._id)))

    def free(self) -> None:
        """Let go of the board. It must be halted."""
        with self._lock:
            self._check("AlpDevFree", self._api.AlpDevFree(Id(self._id)))

    def control(self, control: DeviceControl, value: int) -> None:
        """Set something of the device."""
        with self._lock:
            self._check("AlpDevControl", self._api.AlpDevControl(Id(self._id), Int(control), Int(value)))

    def inquire(self, inquiry: DeviceInquiry) -> int:
        """Ask the device."""
        answer = Int()
        with self._lock:
            code = self._api.AlpDevInquire(Id(self._id), Int(inquiry), ctypes.byref(answer))
        self._check("AlpDevInquire", code)
        return answer.value

    def allocate_sequence(self, planes: int) -> int:
        """Reserve memory for one-bit pictures and give the sequence's id.

        Raises:
            PatternMemoryFull: the board has no such room in one piece.
        """
        handle = Id(INVALID_ID)
        with self._lock:
            code = self._api.AlpSeqAlloc(Id(self._id), Int(1), Int(planes), ctypes.byref(handle))
        if code == ReturnCode.MEMORY_FULL:
            free = self.inquire(DeviceInquiry.AVAIL_MEMORY)
            raise PatternMemoryFull(
                self.name, planes, free, "patterns in one piece (AlpSeqAlloc: 1007 ALP_MEMORY_FULL)"
            )
        self._check("AlpSeqAlloc", code)
        return self._valid("sequence", handle.value)

    def free_sequence(self, sequence: int) -> None:
        """Give a sequence's memory back."""
        with self._lock:
            self._check("AlpSeqFree", self._api.AlpSeqFree(Id(self._id), Id(sequence)))

    def control_sequence(self, sequence: int, control: SequenceControl, value: int) -> None:
        """Set something of a sequence."""
        with self._lock:
            code = self._api.AlpSeqControl(Id(self._id), Id(sequence), Int(control), Int(value))
        self._check("AlpSeqControl", code)

    def inquire_sequence(self, sequence: int, inquiry: SequenceInquiry) -> int:
        """Ask about a sequence."""
        answer = Int()
        with self._lock:
            code = self._api.AlpSeqInquire(Id(self._id), Id(sequence), Int(inquiry), ctypes.byref(answer))
        self._check("AlpSeqInquire", code)
        return answer.value

    def set_timing(self, sequence: int, *, picture_us: int, delay_us: int, width_us: int) -> None:
        """Set a sequence's times; 0 takes the default. There is no illuminate time in uninterrupted mode."""
        times = (Int(DEFAULT), Int(picture_us), Int(delay_us), Int(width_us), Int(DEFAULT))
        with self._lock:
            self._check("AlpSeqTiming", self._api.AlpSeqTiming(Id(self._id), Id(sequence), *times))

    def put(self, sequence: int, first: int, planes: Bytes) -> None:
        """Store ``planes``, ``(n, rows, columns / 8)``, from place ``first`` on. Blocks."""
        data = np.ascontiguousarray(planes)
        address = ctypes.c_void_p(data.ctypes.data)
        self._check("AlpSeqPut", self._api.AlpSeqPut(Id(self._id), Id(sequence), Int(first), Int(len(data)), address))

    def start(self, sequence: int) -> None:
        """Play a sequence once and return at once."""
        with self._lock:
            self._check("AlpProjStart", self._api.AlpProjStart(Id(self._id), Id(sequence)))

    def control_projection(self, control: ProjectionControl, value: int) -> None:
        """Set something of the projection; the board must be idle."""
        with self._lock:
            self._check("AlpProjControl", self._api.AlpProjControl(Id(self._id), Int(control), Int(value)))

    def inquire_projection(self, inquiry: ProjectionInquiry) -> int:
        """Ask about the projection."""
        answer = Int()
        with self._lock:
            code = self._api.AlpProjInquire(Id(self._id), Int(inquiry), ctypes.byref(answer))
        self._check("AlpProjInquire", code)
        return answer.value

    def write_flut(self, mode: FlutMode, entries: Integers) -> None:
        """Write the frame look-up table from its beginning, 4096 entries a call."""
        wide = mode is FlutMode.BITS_18
        control = ProjectionControl.FLUT_WRITE_18BIT if wide else ProjectionControl.FLUT_WRITE_9BIT
        for first in range(0, len(entries), FLUT_WRITE_ENTRIES):
            part = entries[first : first + FLUT_WRITE_ENTRIES]
            table = FlutWrite(nOffset=first, nSize=len(part))
            table.FrameNumbers[: len(part)] = part.tolist()
            with self._lock:
                code = self._api.AlpProjControlEx(Id(self._id), Int(control), ctypes.byref(table))
            self._check("AlpProjControlEx", code)

    def playing(self) -> bool:
        """Whether pictures are being played.

        Raises:
            ProtocolViolation: a state that the header does not know.
        """
        state = self.inquire_projection(ProjectionInquiry.PROJ_STATE)
        if state not in (ProjectionState.ACTIVE, ProjectionState.IDLE):
            raise ProtocolViolation(
                device=self.name,
                saw=f"a projection state of {state}",
                expected="1200 (active) or 1201 (idle)",
                remedy="check that the library fits the board (`kinopix drivers`), then power-cycle the board",
            )
        return state == ProjectionState.ACTIVE

    def pictures_left(self) -> int:
        """Pictures that the run under way has still to show."""
        progress = ProjectionProgress()
        with self._lock:
            code = self._api.AlpProjInquireEx(Id(self._id), Int(ProjectionInquiry.PROGRESS), ctypes.byref(progress))
        self._check("AlpProjInquireEx", code)
        return progress.nFrameCounter

    def _check(self, call: str, code: int) -> None:
        if code != ReturnCode.OK:
            raise error_of(code, call, self.name)

    def _valid(self, what: str, handle: int) -> int:
        if handle == INVALID_ID:
            raise ProtocolViolation(
                device=self.name,
                saw=f"ALP_OK with an invalid {what} id",
                expected=f"a {what} id",
                remedy="check that the library fits the board (`kinopix drivers`)",
            )
        return handle
