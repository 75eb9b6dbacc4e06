"""The counters of a USB-CTR: registers, and what they have counted at a moment (h10682-daq.md 5.2)."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from protocols import Floats, Integers
from sim_backends.wire.usb_ctr.debounce import debounce_s
from sim_backends.wire.usb_ctr.settings import UsbCtrEmulatorSettings
from sim_backends.wire.usb_ctr.timers import Timer

CLEAR_ON_READ = 0x01
COUNT_DOWN = 0x04
_TICKS_S = (1 / 48e6, 10 / 48e6, 100 / 48e6, 1000 / 48e6)
_TOTALIZE, _PERIOD = 0, 1
_PERIODS = (1, 10, 100, 1000)

Register = NDArray[np.uint64]


@dataclass(frozen=True, eq=False)
class Moments:
    """Times at which counters are latched, and what had come by then since power-up."""

    time_s: Floats
    """``(n,)`` times, in seconds."""

    photons: Integers
    """``(n,)`` photons by each time."""

    edges: Integers
    """``(n,)`` sync edges by each time."""


@dataclass
class Registers:
    """What the host has written for one counter."""

    debounce: int
    mode: int = 0
    options: int = 0
    gate: int = 0
    output: int = 0
    out_values: tuple[int, int] = (0, 0)
    limits: tuple[int, int] = (0, 2**64 - 1)
    zero: int = 0
    latched_s: float = 0.0


class Counters:
    """All counters of a device. Totalizing and the period: x1 of the sync, any multiple of a timer that is wired to the input.

    Other modes and gates count nothing.
    """

    def __init__(self, settings: UsbCtrEmulatorSettings, timers: list[Timer]) -> None:
        self.registers = [
            Registers(settings.debounce_at_power_up) for _ in range(4 if settings.model == "USB-CTR04" else 8)
        ]
        self._settings = settings
        self._timers = timers

    def __len__(self) -> int:
        """How many there are."""
        return len(self.registers)

    def _passes(self, index: int, high_s: float) -> bool:
        """Whether a pulse gets through a counter's input."""
        settings = self._settings
        filtered_s = debounce_s(self.registers[index].debounce, settings.debounce_table)
        return high_s >= max(settings.min_pulse_s, filtered_s)

    def total(self, index: int, at: Moments) -> Integers:
        """Pulses that have come through a counter's input since power-up, ``(n,)``."""
        settings = self._settings
        total = np.zeros(len(at.time_s), np.int64)
        if index == settings.photon_counter and self._passes(index, settings.photon_pulse_s):
            total = total + at.photons
        if index == settings.sync_counter:
            total = total + at.edges
        for wire in settings.timer_wires:
            timer = self._timers[wire.timer]
            if wire.counter == index and self._passes(index, min(timer.high_s, timer.low_s)):
                total = total + timer.pulses(at.time_s)
        return total

    def latch(self, index: int, at: Moments) -> Register:
        """Read a counter at each moment, clearing it where its options say so."""
        register = self.registers[index]
        if register.mode & 0x03 == _PERIOD and index == self._settings.sync_counter:
            period_s = at.time_s - np.concatenate([[register.latched_s], at.time_s[:-1]])
            register.latched_s = float(at.time_s[-1])
            ticks: Register = np.rint(period_s / _TICKS_S[register.mode >> 4 & 0x03]).astype(np.uint64)
            return ticks
        register.latched_s = float(at.time_s[-1])
        if register.mode & 0x03 == _PERIOD:
            return np.full(len(at.time_s), self._timer_period(index), np.uint64)
        if register.mode & 0x03 != _TOTALIZE:
            return np.zeros(len(at.time_s), np.uint64)
        total = self.total(index, at)
        if register.options & CLEAR_ON_READ:
            count = total - np.concatenate([[register.zero], total[:-1]])
            register.zero = int(total[-1])
        else:
            count = total - register.zero
        value: Register = (-count if register.options & COUNT_DOWN else count).astype(np.int64).view(np.uint64)
        return value

    def _timer_period(self, index: int) -> int:
        """1, 10, 100 or 1000 periods of the timer on this input in ticks; 0 where none runs."""
        mode = self.registers[index].mode
        for wire in self._settings.timer_wires:
            timer = self._timers[wire.timer]
            if wire.counter == index and timer.runs:
                return round(_PERIODS[mode >> 2 & 0x03] * (timer.high_s + timer.low_s) / _TICKS_S[mode >> 4 & 0x03])
        return 0

    def put(self, index: int, value: int, at: Moments) -> None:
        """Set a counter to ``value`` at the last moment of ``at``."""
        signed = (value + 2**63) % 2**64 - 2**63
        down = self.registers[index].options & COUNT_DOWN
        self.registers[index].zero = int(self.total(index, at)[-1]) + (signed if down else -signed)
