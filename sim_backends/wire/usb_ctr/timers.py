"""The pulse timers of a USB-CTR, which a wire may bring to a counter (h10682-daq.md 5.2)."""

import numpy as np

from protocols import Floats, Integers

BASE_HZ = 96e6
ENABLE = 0x01
RUNNING = 0x02


class Timer:
    """One timer: registers in ticks of 96 MHz, and the pulses that it has given."""

    def __init__(self) -> None:
        self.control = 0
        self.period = 0
        self.width = 0
        self.count = 0
        self.delay = 0
        self._since_s = 0.0
        self._before = 0

    @property
    def high_s(self) -> float:
        """Width of a pulse."""
        return (self.width + 1) / BASE_HZ

    @property
    def low_s(self) -> float:
        """Time between two pulses."""
        return (self.period - self.width) / BASE_HZ

    @property
    def runs(self) -> bool:
        """Whether it is on and its registers leave room for a pulse."""
        return bool(self.control & ENABLE) and self.period >= 1 and self.width < self.period

    def _since_start(self, time_s: Floats) -> Integers:
        if not self.runs:
            return np.zeros(len(time_s), np.int64)
        ticks = (time_s - self._since_s) * BASE_HZ - self.delay
        # A small part of a tick keeps a whole number of periods whole in floating point.
        pulses = np.maximum(0, np.floor((ticks + 1e-3) / (self.period + 1))).astype(np.int64)
        return np.minimum(pulses, self.count) if self.count else pulses

    def pulses(self, time_s: Floats) -> Integers:
        """Pulses since power-up, at each time."""
        return self._before + self._since_start(time_s)

    def change(self, now_s: float, **registers: int) -> None:
        """Write registers, in any order; pulses given until now stay given. Enabling starts the train anew.

        A period below 1 or a pulse as long as the period is kept and gives no pulse: clients write one register after another.
        """
        self._before = int(self.pulses(np.array([now_s]))[0])
        self._since_s = now_s
        for name, value in registers.items():
            setattr(self, name, value)

    def status(self, now_s: float) -> int:
        """The control register as it reads: bit 1 while pulses come."""
        given = int(self._since_start(np.array([now_s]))[0])
        runs = bool(self.control & ENABLE) and not (self.count and given >= self.count)
        return (self.control & ~RUNNING) | (RUNNING if runs else 0)
