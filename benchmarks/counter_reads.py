"""What the USB-CTR driver asks of the computer: ``python -m benchmarks.counter_reads [--seconds 5] [--repeats 5]``.

A run at 20 kHz is read from a board that answers at once, in one process by turns: each sample in a packet of its own, and full
packets of 256 words (``sync_counter``). Processor time is that of driver and pyusb together, without libusb; the time
on the bus is transfers times 125 us, the microframe that a transfer waits for at least where only one is under way [I].
"""

import argparse
import os
import time
from array import array
from typing import Any

import numpy as np

from drivers.h10682.counter import H10682Counter
from drivers.usb_ctr import UsbCtrSettings
from drivers.usb_ctr.board import open_board
from drivers.usb_ctr.driver import usb_ctr_counter
from protocols import CounterRun

RATE_HZ = 20_000
MICROFRAME_S = 125e-6


class Descriptor:
    """A USB descriptor: the fields that matter, 0 for the rest."""

    def __init__(self, **fields: int) -> None:
        """Keep the fields."""
        self.__dict__.update(fields)

    def __getattr__(self, name: str) -> int:
        """0 for what was not given."""
        if name.startswith("_"):
            raise AttributeError(name)
        return 0


class Backend:
    """A ``usb.backend.IBackend`` of one board whose samples are all there, and which costs next to nothing."""

    def __init__(self, samples: bytes) -> None:
        """Load ``samples``, 16 bits each."""
        self.transfers = 0
        self._samples, self._at, self._packet, self._scans = samples, 0, 2, 0

    def enumerate_devices(self) -> list[int]:
        """One board."""
        return [0]

    def get_parent(self, _device: int) -> None:
        """No hub."""

    def get_device_descriptor(self, _device: int) -> Descriptor:
        """A USB-CTR04."""
        return Descriptor(idVendor=0x09DB, idProduct=0x012E, bNumConfigurations=1)

    def get_configuration_descriptor(self, _device: int, _configuration: int) -> Descriptor:
        """The one configuration."""
        return Descriptor(bConfigurationValue=1, bNumInterfaces=1)

    def get_interface_descriptor(
        self, _device: int, _interface: int, alternate: int, _configuration: int
    ) -> Descriptor:
        """The one interface."""
        if alternate:
            raise IndexError
        return Descriptor(bNumEndpoints=1)

    def get_endpoint_descriptor(self, *_which: int) -> Descriptor:
        """The scan endpoint."""
        return Descriptor(bEndpointAddress=0x86, bmAttributes=2, wMaxPacketSize=512)

    def open_device(self, device: int) -> int:
        """A handle."""
        return device

    def get_configuration(self, _handle: int) -> int:
        """Configured."""
        return 1

    def nothing(self, *_arguments: int) -> None:
        """What costs nothing here."""

    close_device = claim_interface = release_interface = clear_halt = nothing

    def ctrl_transfer(self, _handle: int, kind: int, request: int, *rest: Any) -> int:
        """Status well, as many edges as samples; SCAN_START tells packet size and number of samples."""
        data = rest[2]
        if kind == 0xC0:
            answers = {0x40: b"\x02\x01", 0x48: b"01234567", 0x52: b"\x02\x01", 0x10: self._scans.to_bytes(8, "little")}
            data[: len(answers[request])] = array("B", answers[request])
        elif request == 0x21:
            sent = bytes(data)
            self._scans, self._packet = int.from_bytes(sent[:4], "little"), 2 * (sent[12] + 1)
            self._at = 0
        return len(data)

    def bulk_read(self, _handle: int, _endpoint: int, _interface: int, buffer: Any, _timeout: int) -> int:
        """The next packet; none of a scan of full packets before it has started."""
        self.transfers += 1
        packet = self._samples[self._at : self._at + self._packet]
        self._at += len(packet)
        buffer[: len(packet)] = array("B", packet)
        return len(packet)

    intr_read = iso_read = bulk_read


class Silent(Backend):
    """The same, without a sample until a scan of a known length starts: the driver looks for one before any edge."""

    def bulk_read(self, _handle: int, _endpoint: int, _interface: int, buffer: Any, _timeout: int) -> int:
        """As of any backend."""
        if self._scans:
            return super().bulk_read(_handle, _endpoint, _interface, buffer, _timeout)
        self.transfers += 1
        return 0


class Clock:
    """Time that passes only by sleeping."""

    time_s = 0.0

    def now_s(self) -> float:
        """Seconds."""
        return self.time_s

    def sleep_s(self, duration_s: float) -> None:
        """Pass it."""
        self.time_s += duration_s


def read(settings: UsbCtrSettings, backend: Backend, n: int) -> tuple[float, int]:
    """Processor time in seconds and transfers of one run of ``n`` bins."""
    counter: H10682Counter = usb_ctr_counter(settings, open_board(backend, None), Clock())
    began_s, got = time.process_time(), 0
    counter.arm(CounterRun(n_bins=n, n_expected=n, period_s=1 / RATE_HZ))
    while got < n:
        got += len(counter.read(1.0))
    took_s = time.process_time() - began_s
    counter.disarm()
    return took_s, backend.transfers


def main() -> None:
    """Print one line a way, and the ratio."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=5.0, help="of the run")
    parser.add_argument("--repeats", type=int, default=5, help="of which the median counts")
    arguments = parser.parse_args()
    n = round(arguments.seconds * RATE_HZ)
    samples = np.asarray(np.random.default_rng(1).poisson(50, n + 1), dtype="<u2").tobytes()
    print(f"cores {os.cpu_count()}, load {os.getloadavg()[0]:.1f}, {n} samples at {RATE_HZ} Hz")
    ways = {
        "single": lambda: read(UsbCtrSettings(), Backend(samples), n),
        "full": lambda: read(UsbCtrSettings(sync_counter=2), Silent(samples), n),
    }
    taken: dict[str, list[tuple[float, int]]] = {name: [] for name in ways}
    for _ in range(arguments.repeats):
        for name, way in ways.items():
            taken[name].append(way())
    figures: dict[str, tuple[float, float]] = {}
    for name, runs in taken.items():
        cpu_s = float(np.median([took_s for took_s, _ in runs]))
        a_second = runs[0][1] / arguments.seconds
        figures[name] = (cpu_s, a_second)
        print(
            f"{name:7} {a_second:8.0f} reads a second, {1e6 * cpu_s / n:6.2f} us of processor a sample, "
            f"{a_second * MICROFRAME_S:5.2f} s on the bus a second"
        )
    (single_s, single_reads), (full_s, full_reads) = figures["single"], figures["full"]
    print(f"ratio   {single_reads / full_reads:8.0f} x fewer reads, {single_s / full_s:6.1f} x less processor time")


if __name__ == "__main__":
    main()
