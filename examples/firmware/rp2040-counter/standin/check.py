# SPDX-License-Identifier: BSD-3-Clause
"""Kinopix's driver on the firmware on an emulated RP2040: ``python check.py counter.bin`` (README.md says how to make it).

300 bins of 100 us, twice, bin k with 7 k mod 50 pulses.
"""

import sys
from pathlib import Path

import numpy as np

from drivers.serial_counter.driver import open_serial_counter
from drivers.serial_counter.settings import SerialCounterSettings
from protocols import BenchContext, CounterRun, MonotonicClock
from sim_backends.wire.process_port import ProcessPort

BINS, PERIOD_CYCLES, CLOCK_HZ = 300, 12_500, 125e6


def main() -> None:
    """Count twice, and print what came."""
    clock = MonotonicClock()
    emulator = ["node", "serve.mjs", str(Path(sys.argv[1]).resolve()), str(BINS), str(PERIOD_CYCLES)]
    port = ProcessPort(emulator, Path(__file__).parent)
    settings = SerialCounterSettings(
        reply_margin_s=20.0, max_sync_rate_hz=20_000
    )  # it is some 20 times slower than a chip
    with open_serial_counter(settings, BenchContext(clock=clock, transport=port)) as counter:
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
