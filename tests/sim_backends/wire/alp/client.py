"""A tiny ctypes client, as a lab script would call the vendor's library."""

import ctypes
from typing import Any

import numpy as np

from protocols import Bytes
from sim_backends.bench import OpticalBench, SceneSettings
from sim_backends.wire.alp import AlpEmulatorSettings, AlpLibrary, EmulatedAlpBoard


class Client:
    """Calls by name; out-parameters come back beside the code."""

    def __init__(self, bench: OpticalBench | None = None, **settings: Any) -> None:
        self.bench = bench or OpticalBench(SceneSettings())
        self.library = AlpLibrary(EmulatedAlpBoard(AlpEmulatorSettings.model_validate(settings), self.bench))

    def __call__(self, function: str, *arguments: object) -> int:
        code: int = getattr(self.library, function)(*arguments)
        return code

    def ask(self, function: str, *arguments: int) -> tuple[int, int]:
        """Call a function whose last parameter is an out-parameter of 32 bits."""
        value = ctypes.c_uint32(0xDEAD)
        return self(function, *arguments, ctypes.byref(value)), value.value

    def device(self) -> int:
        """Allocate the board."""
        code, device = self.ask("AlpDevAlloc", 0, 0)
        assert code == 0
        return device

    def sequence(self, device: int, pictures: int, picture_us: int = 50, pulse_us: int = 10) -> int:
        """Allocate a packed, uninterrupted 1-bit sequence with its timing."""
        code, sequence = self.ask("AlpSeqAlloc", device, 1, pictures)
        assert code == 0
        for control, value in ((2110, 2), (2103, 1), (2104, 2106)):
            assert self("AlpSeqControl", device, sequence, control, value) == 0
        assert self("AlpSeqTiming", device, sequence, 0, picture_us, 0, pulse_us, 0) == 0
        return sequence

    def put(self, device: int, sequence: int, pictures: Bytes, offset: int = 0) -> int:
        """Upload ``(n, ...)`` pictures as they stand in memory."""
        return self("AlpSeqPut", device, sequence, offset, len(pictures), pictures.ctypes.data_as(ctypes.c_void_p))

    def flut(self, device: int, control: int, offset: int, frames: list[int]) -> int:
        """Write a stretch of the frame look-up table with a packed tFlutWrite."""
        table = FlutWrite(nOffset=offset, nSize=len(frames))
        table.FrameNumbers[: len(frames)] = frames
        return self("AlpProjControlEx", device, control, ctypes.byref(table))


class FlutWrite(ctypes.Structure):
    """``tFlutWrite`` of dlp7000.md 3.7."""

    _pack_ = 1
    _fields_ = (("nOffset", ctypes.c_int32), ("nSize", ctypes.c_int32), ("FrameNumbers", ctypes.c_uint32 * 4096))


def packed(*lit: bool) -> Bytes:
    """Full-array XGA pictures, all on or all off: ``(n, 768, 128)``."""
    return np.stack([np.full((768, 128), 255 if on else 0, np.uint8) for on in lit])
