"""A scripted ALP function table: it records every call, answers what the test says, and keeps books on what is held.

No emulator: it knows no rule of the board but who holds what and how long a run takes. Numbers are those of the vendor's header.
"""

import ctypes
from collections.abc import Callable
from functools import partial
from typing import Any

from drivers.alp import Dlp7000, Dlp7000Settings
from drivers.alp.binding import bind

PLANE_BYTES = 98_304
FUNCTIONS = frozenset(
    {"AlpDevAlloc", "AlpDevHalt", "AlpDevFree", "AlpDevControl", "AlpDevInquire", "AlpSeqAlloc", "AlpSeqFree"}
    | {"AlpSeqControl", "AlpSeqTiming", "AlpSeqInquire", "AlpSeqPut", "AlpProjStart", "AlpProjControl"}
    | {"AlpProjControlEx", "AlpProjInquire", "AlpProjInquireEx"}
)
DEVICE = 7


class ManualClock:
    """Time that passes only while somebody sleeps."""

    def __init__(self) -> None:
        self.time_s = 100.0

    def now_s(self) -> float:
        return self.time_s

    def sleep_s(self, duration_s: float) -> None:
        self.time_s += max(0.0, duration_s)


class FakeAlp:
    """What a test scripts (``answers``, ``codes``, ``fail_at``) and what it looks at afterwards (the rest)."""

    def __init__(self) -> None:
        self.clock = ManualClock()
        self.answers: dict[int, int] = {
            2000: 4711,  # ALP_DEVICE_NUMBER
            2001: 0x0403,  # ALP_VERSION
            2003: 43_690,  # ALP_AVAIL_MEMORY
            2021: 4,  # ALP_DEV_DMDTYPE: DLP7000
            2057: 768,  # ALP_DEV_DISPLAY_HEIGHT
            2058: 1024,  # ALP_DEV_DISPLAY_WIDTH
            2209: 130_000,  # ALP_MAX_SYNCH_DELAY
            2211: 44,  # ALP_MIN_PICTURE_TIME
            2213: 10_000_000,  # ALP_MAX_PICTURE_TIME
            2324: 65_536,  # ALP_FLUT_MAX_ENTRIES9
        }
        self.codes: dict[str | tuple[str, int], int] = {}
        self.fail_at: tuple[int, int] | None = None
        self.during_put: Callable[[], int] = lambda: 0
        self.frames_left = 0
        self.keep_opening = False
        self.calls: list[tuple[Any, ...]] = []
        self.held = False
        self.sequences: dict[int, int] = {}
        self.stored: dict[int, bytes] = {}
        self.flut: list[int] = []
        self.plays_until_s = 0.0
        self._next_id = 0x80000001  # above 2**31: ids are unsigned

    def __getattr__(self, name: str) -> Callable[..., int]:
        if name in FUNCTIONS:
            return partial(self.call, name)
        raise AttributeError(name)

    def named(self, *names: str) -> list[tuple[Any, ...]]:
        """Calls of these functions, in order."""
        return [call for call in self.calls if call[0] in names]

    def open(self, **settings: Any) -> Dlp7000:
        """The driver on this table, with nothing on record yet unless ``keep_opening``."""
        driver = Dlp7000(bind(self), Dlp7000Settings(**settings), self.clock, library="fake", simulated=True)
        if not self.keep_opening:
            self.calls.clear()
        return driver

    def call(self, name: str, *arguments: Any) -> int:
        """Record one call of a C function and answer it."""
        numbers = tuple(a.value for a in arguments if isinstance(a, (ctypes.c_int32, ctypes.c_uint32)))
        self.calls.append((name, *numbers))
        if self.fail_at is not None and len(self.calls) - 1 == self.fail_at[0]:
            return self.fail_at[1]
        selector = numbers[2:3] if name.startswith("AlpSeq") else numbers[1:2]
        code = self.codes.get(name, 0) or (self.codes.get((name, selector[0]), 0) if selector else 0)
        return code or self._obey(name, numbers, arguments[-1])

    def _obey(self, name: str, numbers: tuple[int, ...], last: Any) -> int:
        match name:
            case "AlpDevAlloc":
                last._obj.value, self.held = DEVICE, True
            case "AlpDevFree":
                self.held = False
                self.sequences.clear()
            case "AlpSeqAlloc":
                last._obj.value = self._next_id
                self.sequences[self._next_id] = numbers[2]
                self._next_id += 1
            case "AlpSeqFree":
                del self.sequences[numbers[1]]
            case "AlpSeqTiming":
                for inquiry, value in zip((2203, 2205, 2206), numbers[3:6], strict=True):
                    self.answers[-inquiry] = value
            case "AlpSeqPut":
                return self._put(numbers[2], numbers[3], last)
            case "AlpProjStart":
                pictures = len(self.flut) or self.sequences[numbers[1]]
                self.plays_until_s = self.clock.now_s() + pictures * self.answers[-2203] / 1e6
            case "AlpDevHalt":
                self.plays_until_s = self.clock.now_s()
            case "AlpProjControlEx":
                table = last._obj
                assert (table.nOffset, table.nSize <= 4096) == (len(self.flut), True)
                self.flut += table.FrameNumbers[: table.nSize]
            case "AlpProjInquireEx":
                last._obj.nFrameCounter = self.frames_left
            case "AlpDevInquire" | "AlpProjInquire" | "AlpSeqInquire":
                inquiry = numbers[-1]
                default = 1200 if self.clock.now_s() < self.plays_until_s - 1e-9 else 1201
                last._obj.value = self.answers.get(inquiry, self.answers.get(-inquiry, default))
            case _:
                pass
        return 0

    def _put(self, first: int, pictures: int, data: ctypes.c_void_p) -> int:
        code = self.during_put()
        if code == 0:
            raw = ctypes.string_at(data.value or 0, pictures * PLANE_BYTES)
            for place in range(pictures):
                self.stored[first + place] = raw[place * PLANE_BYTES : (place + 1) * PLANE_BYTES]
        return code
