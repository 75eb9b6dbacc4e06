# SPDX-License-Identifier: BSD-3-Clause
"""Kinopix's driver on the firmware on an emulated RP2040: ``python check.py counter.bin`` (README.md says how to make it).

300 bins of 100 us, twice, bin k with 7 k mod 50 pulses.
"""

import subprocess
import sys
from pathlib import Path
from threading import Lock, Thread

import numpy as np

from drivers.serial_counter.driver import open_serial_counter
from drivers.serial_counter.settings import SerialCounterSettings
from protocols import BenchContext, CounterRun, MonotonicClock

BINS, PERIOD_CYCLES, CLOCK_HZ = 300, 12_500, 125e6


class Port:
    """The emulator's standard input and output as a serial port."""

    timeout: float | None = 0.0

    def __init__(self, image: str) -> None:
        """Start the emulator."""
        command = ["node", "serve.mjs", str(Path(image).resolve()), str(BINS), str(PERIOD_CYCLES)]
        pipe = subprocess.PIPE
        self._chip = subprocess.Popen(command, stdin=pipe, stdout=pipe, cwd=Path(__file__).parent, bufsize=0)  # noqa: S603 - ours
        self._heard, self._lock = b"", Lock()
        Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        while self._chip.stdout and (data := self._chip.stdout.read(4096)):
            with self._lock:
                self._heard += data

    @property
    def in_waiting(self) -> int:
        """Bytes that can be read at once."""
        return len(self._heard)

    def read(self, size: int = 1) -> bytes:
        """Read up to ``size`` bytes."""
        with self._lock:
            data, self._heard = self._heard[:size], self._heard[size:]
        return data

    def write(self, b: bytes) -> int:
        """Write all of it."""
        return self._chip.stdin.write(b) or 0 if self._chip.stdin else 0

    def reset_input_buffer(self) -> None:
        """Throw away what came before."""
        with self._lock:
            self._heard = b""

    def close(self) -> None:
        """End the emulator."""
        self._chip.kill()
        self._chip.wait()


def main() -> None:
    """Count twice, and print what came."""
    clock = MonotonicClock()
    settings = SerialCounterSettings(
        reply_margin_s=20.0, max_sync_rate_hz=20_000
    )  # it is some 20 times slower than a chip
    with open_serial_counter(settings, BenchContext(clock=clock, transport=Port(sys.argv[1]))) as counter:
        print(counter.identity.model, "ticks of", counter.limits.edge_time_resolution_s, "s")
        for _ in range(2):
            counter.arm(CounterRun(n_bins=BINS, n_expected=BINS, period_s=PERIOD_CYCLES / CLOCK_HZ))
            counts, steps_s = np.empty(0), np.empty(0)
            while len(counts) < BINS:
                block = counter.read(20.0)
                counts = np.append(counts, block.counts)
                if block.opening_edge_s is not None and block.closing_edge_s is not None:
                    steps_s = np.append(steps_s, np.diff(np.append(block.opening_edge_s, block.closing_edge_s)))
            clock.sleep_s(2.0)  # for the edges after the run
            right = int((counts == 7 * np.arange(BINS) % 50).sum())
            print(
                f"{right} of {BINS} bins right, {1e6 * steps_s.min():.3f} to {1e6 * steps_s.max():.3f} us long;",
                counter.disarm(),
            )


if __name__ == "__main__":
    main()
