"""What the USB-CTR driver asks of the computer: ``python -m benchmarks.counter_reads [--seconds 3] [--repeats 3]``.

Runs at 20 kHz are read in one process by turns, in real time, through the real package ``usb1`` and a libusb whose bus and board
are ``usb_bus.c`` (compiled here by gcc): a transfer gets its packet in the microframe of 125 us after both are there. Three ways:

``one``      one transfer at a time, and a wait for each, as the driver did it before;
``queued``   32 transfers in flight, as the driver does it now;
``full``     packets of 256 words, queued too, where a counter input counts the sync (``sync_counter``).

How fast each can go is found by letting the board's samples wait before the first is read. Needs gcc and libusb 1.0.
"""

import argparse
import ctypes
import importlib
import os
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, cast

import numpy as np

from drivers.usb_ctr import UsbCtrSettings
from drivers.usb_ctr.board import UsbCtrBoard
from drivers.usb_ctr.driver import usb_ctr_counter
from drivers.usb_ctr.pipe import UsbPipe, find_pipes
from protocols import CounterOverrun, CounterRun, MonotonicClock

usb1: Any = importlib.import_module("usb1")  # without types

RATE_HZ = 20_000
WAITING = 4000
"""Samples that wait on the board before the first is read, of the 8192 that it keeps."""


class OneAtATime:
    """A pipe that waits for each packet, around one that queues transfers."""

    def __init__(self, pipe: Any) -> None:
        """Take over ``pipe``."""
        self._pipe = pipe

    def __getattr__(self, name: str) -> Any:
        """Everything but packets is the other's."""
        return getattr(self._pipe, name)

    def begin_packets(self) -> None:
        """Nothing is queued."""

    end_packets = begin_packets

    def packet(self) -> bytes:
        """One transfer, and the wait for it."""
        try:
            return bytes(self._pipe._handle.bulkRead(0x86, 512, 1))  # noqa: SLF001 - the way that is no longer there
        except usb1.USBErrorTimeout:
            return b""


def compiled(folder: Path) -> Any:
    """The library of ``usb_bus.c``, with the real libusb behind it."""
    out = folder / "usb_bus.so"
    source = Path(__file__).with_name("usb_bus.c")
    command = ["gcc", "-O2", "-fPIC", "-shared", "-o", str(out), str(source)]
    subprocess.run([*command, "-Wl,--no-as-needed", "-l:libusb-1.0.so.0"], check=True)
    return ctypes.CDLL(str(out))


def read(settings: UsbCtrSettings, pipe: UsbPipe, library: Any, seconds: float) -> dict[str, float]:
    """One run: processor time a sample, transfers a second, samples a second while they wait; how many came before an overrun."""
    clock, n = MonotonicClock(), round(seconds * RATE_HZ)
    before = library.kinopix_transfers()
    figures: dict[str, float] = {}
    with usb_ctr_counter(settings, UsbCtrBoard(pipe), clock) as counter:
        counter.arm(CounterRun(n_bins=n, n_expected=n, period_s=1 / RATE_HZ))
        clock.sleep_s(WAITING / RATE_HZ)
        cpu_s, began_s, got = time.process_time(), time.monotonic(), 0
        try:
            while got < n:
                got += len(counter.read(1.0))
                if "fast_hz" not in figures and got >= WAITING:
                    figures["fast_hz"] = got / (time.monotonic() - began_s)
        except CounterOverrun:
            figures["overrun"] = 1.0
        took_s = time.monotonic() - began_s
        figures |= {
            "cpu_us": 1e6 * (time.process_time() - cpu_s) / max(1, got),
            "got": float(got),
            "transfers_hz": (library.kinopix_transfers() - before) / (took_s + WAITING / RATE_HZ),
        }
    return figures


def main() -> None:
    """Print one line a way, and the ratios."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=3.0, help="of the run")
    parser.add_argument("--repeats", type=int, default=3, help="of which the median counts")
    arguments = parser.parse_args()
    with TemporaryDirectory(prefix="kinopix-") as folder:
        library = compiled(Path(folder))
        usb1.loadLibrary(library)
        measure(library, arguments.seconds, arguments.repeats)


def measure(library: Any, seconds: float, repeats: int) -> None:
    """Run each way by turns."""

    def pipe() -> UsbPipe:
        (found,) = find_pipes()
        found.claim()
        return found

    ways: dict[str, Callable[[], dict[str, float]]] = {
        "one": lambda: read(UsbCtrSettings(), cast("UsbPipe", OneAtATime(pipe())), library, seconds),
        "queued": lambda: read(UsbCtrSettings(), pipe(), library, seconds),
        "full": lambda: read(UsbCtrSettings(sync_counter=2), pipe(), library, seconds),
    }
    print(f"cores {os.cpu_count()}, load {os.getloadavg()[0]:.1f}, {seconds * RATE_HZ:.0f} samples at {RATE_HZ} Hz")
    taken: dict[str, list[dict[str, float]]] = {name: [] for name in ways}
    for _ in range(repeats):
        for name, way in ways.items():
            taken[name].append(way())
    median = {
        name: {
            key: float(np.median([run.get(key, 0.0) for run in runs]))
            for key in ("cpu_us", "fast_hz", "transfers_hz", "got")
        }
        for name, runs in taken.items()
    }
    for name, figures in median.items():
        overruns = sum("overrun" in run for run in taken[name])
        end = (
            f"OVERRUN in {overruns} of {repeats}, after {figures['got']:.0f} samples"
            if overruns
            else "every sample came"
        )
        print(
            f"{name:7} {figures['transfers_hz']:8.0f} transfers a second, {figures['cpu_us']:6.2f} us of processor a sample, "
            f"up to {figures['fast_hz']:7.0f} samples a second; {end}"
        )
    for name in ("queued", "full"):
        faster = median[name]["fast_hz"] / max(1.0, median["one"]["fast_hz"])
        cheaper = median["one"]["cpu_us"] / median[name]["cpu_us"]
        print(f"{name:7} / one: {faster:.1f} x as fast, {cheaper:.1f} x less processor time a sample")


if __name__ == "__main__":
    main()
