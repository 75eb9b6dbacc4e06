"""An emulated USB-CTR as the package ``usb1`` shows it: the one typed place for a package without types."""

import importlib
import struct
from collections.abc import Sequence
from typing import Any

import pytest

from protocols import BenchContext
from sim_backends.bench import OpticalBench
from sim_backends.wire.usb_ctr import UsbCtrContext, UsbCtrEmulatorSettings, open_emulator
from tests.sim_backends.projector import all_on, bench_with, pixel, show

PHOTONS = {"kind": "poisson", "peak_counts": 250.0, "seed": 3}
_usb1: Any = importlib.import_module("usb1")
USBError = _usb1.USBError
NO_DEVICE, STALL, TIMEOUT, OVERFLOW, BUSY, NO_ACCESS, NOT_FOUND, NOT_SUPPORTED = -4, -9, -7, -8, -6, -3, -5, -12
"""Numbers of libusb's errors."""


def find(context: UsbCtrContext, product_id: int | None = None) -> Any:
    """Open the only device on the bus, if it has that number; None where there is none."""
    found: list[Any] = [
        device
        for device in context.getDeviceIterator()
        if device.getVendorID() == 0x09DB and product_id in {None, device.getProductID()}
    ]
    return found[0].open() if found else None


class Rig:
    """A bench, an emulated device on it, and its handle once it is asked for."""

    def __init__(self, *, scene: dict[str, object] | None = None, loaded: bool = True, **settings: object) -> None:
        self.bench: OpticalBench = bench_with(**({"object": "disc", "noise": PHOTONS} | (scene or {})))
        chosen = UsbCtrEmulatorSettings.model_validate({"fpga_configured": loaded} | settings)
        self.context: UsbCtrContext = open_emulator(chosen, BenchContext(clock=self.bench.clock, scene=self.bench))
        self._handle: Any = None

    @property
    def handle(self) -> Any:
        """The open device."""
        if self._handle is None:
            self._handle = find(self.context)
        return self._handle

    def out(self, request: int, value: int = 0, index: int = 0, data: bytes = b"") -> None:
        """A vendor request to the device."""
        assert self.handle.controlWrite(0x40, request, value, index, data, 1000) == len(data)

    def ask(self, request: int, size: int, value: int = 0, index: int = 0) -> bytes:
        """A vendor request from the device."""
        return bytes(self.handle.controlRead(0x40, request, value, index, size, 1000))

    def status(self) -> int:
        """The status word."""
        return int.from_bytes(self.ask(0x40, 2), "little")

    def scan(
        self, elements: Sequence[int] = (0,), *, scans: int = 0, packet_words: int = 1, options: int = 0, pacer: int = 0
    ) -> None:
        """Clear on read, no debounce (the maker's code), and scan on the external clock."""
        for counter in {element & 7 for element in elements}:
            self.out(0x18, 0, counter, bytes([0, 1, 0, 0, 16]))
        self.out(0x20, 0, len(elements) - 1, bytes(elements).ljust(33, b"\0"))
        self.out(0x23)
        self.out(0x21, 0, 0, struct.pack("<IIIBB", scans, 0, pacer, packet_words - 1, options))

    def read(self, size: int = 512, timeout_ms: int = 100) -> list[int]:
        """One bulk transfer, as words."""
        if self.context.holder is None:
            self.handle.claimInterface(0)
        data = bytes(self.handle.bulkRead(0x86, size, timeout_ms))
        return list(struct.unpack(f"<{len(data) // 2}H", data))

    def read_words(self, words: int, timeout_ms: int = 100) -> list[int]:
        """Bulk transfers until so many words are in."""
        got: list[int] = []
        while len(got) < words:
            got += self.read(timeout_ms=timeout_ms)
        return got

    def show(self, pictures: int) -> None:
        """Show pictures, and the guard, from 1 ms from now on."""
        planes = [all_on() if k % 2 else pixel(4, 4) for k in range(pictures)]
        show(self.bench, planes, start_s=self.bench.clock.now_s() + 0.001)

    def bins(self, n: int, first: int = 0) -> list[int]:
        """The bench's own counts."""
        counts: list[int] = self.bench.counts(first, n).tolist()
        return counts


def errno_of(action: Any, *arguments: Any) -> int:
    """Libusb's number of a transfer that fails."""
    with pytest.raises(USBError) as raised:
        action(*arguments)
    return int(raised.value.value)
