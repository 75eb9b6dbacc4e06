"""Requests on counters (0x10 to 0x18) and timers (0x28 to 0x2D)."""

import struct
from collections.abc import Callable

from sim_backends.wire.usb_ctr.counters import Counters, Moments, Registers
from sim_backends.wire.usb_ctr.requests import Read, Stall, Write, exactly, number
from sim_backends.wire.usb_ctr.timers import Timer

_BYTES = {0x11: "mode", 0x12: "options", 0x13: "debounce", 0x14: "gate", 0x15: "output"}
_PARAMETERS = ("mode", "options", "gate", "output", "debounce")
_TIMER_WORDS = {0x29: "period", 0x2A: "width", 0x2B: "count", 0x2C: "delay"}


class RegisterRequests:
    """Reads and writes of the counters' and timers' registers."""

    of_timers = (0x28, *_TIMER_WORDS, 0x2D)
    """Requests on timers, which work before the FPGA is configured (a public test program sets them first)."""

    def __init__(self, counters: Counters, timers: list[Timer], now: Callable[[], Moments]) -> None:
        self._counters = counters
        self._timers = timers
        self._now = now
        self.writes: dict[int, Write] = {
            0x10: self._set_count,
            0x16: lambda value, index, data: self._set_pair("out_values", value, index, data),
            0x17: lambda value, index, data: self._set_pair("limits", value, index, data),
            0x18: self._set_parameters,
            0x28: lambda value, index, _data: self._change(index, control=value & 0xFF),
            0x2D: self._set_timer,
        }
        self.writes |= {request: self._byte_writer(name) for request, name in _BYTES.items()}
        self.writes |= {request: self._word_writer(name) for request, name in _TIMER_WORDS.items()}
        self.reads: dict[int, Read] = {
            0x10: self._count,
            0x16: lambda value, index, _size: self._pair("out_values", value, index),
            0x17: lambda value, index, _size: self._pair("limits", value, index),
            0x18: self._parameters,
            0x28: lambda _value, index, _size: bytes([self._timer(index).status(float(self._now().time_s[-1]))]),
            0x2D: self._timer_parameters,
        }
        self.reads |= {request: self._byte_reader(name) for request, name in _BYTES.items()}
        self.reads |= {request: self._word_reader(name) for request, name in _TIMER_WORDS.items()}

    def _registers(self, index: int) -> Registers:
        if index >= len(self._counters):
            raise Stall
        return self._counters.registers[index]

    def _timer(self, index: int) -> Timer:
        if index >= len(self._timers):
            raise Stall
        return self._timers[index]

    # Counters

    def _count(self, _value: int, index: int, _size: int) -> bytes:
        self._registers(index)
        return int(self._counters.latch(index, self._now())[0]).to_bytes(8, "little")

    def _set_count(self, _value: int, index: int, data: bytes) -> None:
        self._registers(index)
        self._counters.put(index, number(data, 8), self._now())

    def _set_byte(self, name: str, index: int, value: int) -> None:
        """What was counted until now stays counted, also when a filter changes."""
        registers, now = self._registers(index), self._now()
        before = int(self._counters.total(index, now)[0])
        setattr(registers, name, value)
        registers.zero += int(self._counters.total(index, now)[0]) - before

    def _byte_writer(self, name: str) -> Write:
        return lambda value, index, _data: self._set_byte(name, index, value & 0xFF)

    def _byte_reader(self, name: str) -> Read:
        return lambda _value, index, _size: bytes([getattr(self._registers(index), name)])

    def _set_parameters(self, _value: int, index: int, data: bytes) -> None:
        for name, value in zip(_PARAMETERS, exactly(data, 5), strict=True):
            self._set_byte(name, index, value)

    def _parameters(self, _value: int, index: int, _size: int) -> bytes:
        return bytes(getattr(self._registers(index), name) for name in _PARAMETERS)

    def _set_pair(self, name: str, which: int, index: int, data: bytes) -> None:
        pair: list[int] = list(getattr(self._registers(index), name))
        pair[which & 1] = number(data, 8)
        setattr(self._registers(index), name, tuple(pair))

    def _pair(self, name: str, which: int, index: int) -> bytes:
        pair: tuple[int, int] = getattr(self._registers(index), name)
        return pair[which & 1].to_bytes(8, "little")

    # Timers

    def _change(self, index: int, **registers: int) -> None:
        self._timer(index).change(float(self._now().time_s[-1]), **registers)

    def _word_writer(self, name: str) -> Write:
        return lambda _value, index, data: self._change(index, **{name: number(data, 4)})

    def _word_reader(self, name: str) -> Read:
        return lambda _value, index, _size: int(getattr(self._timer(index), name)).to_bytes(4, "little")

    def _set_timer(self, _value: int, index: int, data: bytes) -> None:
        period, width, count, delay = struct.unpack("<4I", exactly(data, 16))
        self._change(index, period=period, width=width, count=count, delay=delay)

    def _timer_parameters(self, _value: int, index: int, _size: int) -> bytes:
        timer = self._timer(index)
        return struct.pack("<4I", timer.period, timer.width, timer.count, timer.delay)
