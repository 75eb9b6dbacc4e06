"""The device behind the bus: requests, FPGA, status, and the bulk endpoint (h10682-daq.md 5.2)."""

import threading
from collections import Counter

from sim_backends.bench import OpticalBench
from sim_backends.wire.usb_ctr.counters import Counters
from sim_backends.wire.usb_ctr.housekeeping import UNLOCK, Housekeeping
from sim_backends.wire.usb_ctr.registers import RegisterRequests
from sim_backends.wire.usb_ctr.requests import Gone, Read, Stall, TimedOut, Write
from sim_backends.wire.usb_ctr.scanner import Scanner
from sim_backends.wire.usb_ctr.settings import ControlFault, FpgaRefused, UsbCtrEmulatorSettings
from sim_backends.wire.usb_ctr.timers import Timer

_RUNNING, _OVERRUN, _FPGA_CONFIGURED, _CONFIGURING = 0x0002, 0x0004, 0x0100, 0x0200
_RESET, _FPGA_CONFIG, _FPGA_DATA = 0x42, 0x50, 0x51


class EmulatedUsbCtrBoard:
    """A USB-CTR04 or 08 from power-up on. Safe to call from many threads."""

    def __init__(self, settings: UsbCtrEmulatorSettings, bench: OpticalBench) -> None:
        self.settings = settings
        self.gone = False
        self._clock = bench.clock
        self._lock = threading.RLock()
        self._calls: Counter[int] = Counter()
        self._max_packet = 512 if settings.high_speed else 64
        self._loaded_bytes: int | None = None
        self._zero_bytes = False
        self._configured = settings.fpga_configured
        timers = [Timer() for _ in range(4)]
        counters = Counters(settings, timers)
        self._scanner = Scanner(settings, bench, counters)
        registers = RegisterRequests(counters, timers, self._scanner.now)
        house = Housekeeping(settings.serial_number)
        on_fpga = {*registers.writes, *self._scanner.writes, 0x00, 0x01, 0x02, 0x43, 0x52}
        self._on_fpga = on_fpga - set(registers.of_timers)  # the timers are the microcontroller's
        self._writes: dict[int, Write] = {
            **registers.writes,
            **self._scanner.writes,
            **house.writes,
            _RESET: self._reset,
            _FPGA_CONFIG: self._configure,
            _FPGA_DATA: self._load,
        }
        self._reads: dict[int, Read] = {
            **registers.reads,
            **self._scanner.reads,
            **house.reads,
            0x40: self._status,
            0x52: lambda _value, _index, _size: settings.fpga_version.to_bytes(2, "little"),
        }

    def write(self, request: int, value: int, index: int, data: bytes, *, timeout_s: float = 1.0) -> None:
        """Carry out a vendor request that brings data.

        Args:
            request: bRequest.
            value: wValue.
            index: wIndex.
            data: the data stage.
            timeout_s: time that passes before a fault gives ``TimedOut``.

        Raises:
            Stall: refused.
            TimedOut: a fault kept the answer back.
            Gone: no device.
        """
        self._begin(request, timeout_s)
        with self._lock:
            if request not in self._writes:
                raise Stall
            if self._works(request):
                self._writes[request](value, index, data)

    def read(self, request: int, value: int, index: int, size: int, *, timeout_s: float = 1.0) -> bytes:
        """Carry out a vendor request that fetches up to ``size`` bytes; see ``write``."""
        self._begin(request, timeout_s)
        with self._lock:
            if request not in self._reads:
                raise Stall
            return self._reads[request](value, index, size)[:size] if self._works(request) else bytes(size)

    def _begin(self, request: int, timeout_s: float) -> None:
        """Note a request, let faults at it, and look at what happened until now."""
        with self._lock:
            self._calls[request] += 1
            nth = self._calls[request]
        for fault in self.settings.faults:
            if isinstance(fault, ControlFault) and (fault.request, fault.nth) == (request, nth):
                self._clock.sleep_s(fault.delay_s)
                if fault.error == "timeout":
                    self._clock.sleep_s(timeout_s)
                    raise TimedOut
                if fault.error == "stall":
                    raise Stall
        with self._lock:
            self._look()
            if request != _FPGA_DATA:
                self._end_configuration()

    def _look(self) -> None:
        self._scanner.look()
        self.gone |= self._scanner.scan is not None and self._scanner.scan.disconnected
        if self.gone:
            raise Gone

    def _works(self, request: int) -> bool:
        """Whether the FPGA is there for a request that needs it."""
        if request not in self._on_fpga or self._configured:
            return True
        if self.settings.unconfigured == "stall":
            raise Stall
        return False

    def _configure(self, _value: int, _index: int, data: bytes) -> None:
        if data != UNLOCK:
            raise Stall
        self._configured, self._loaded_bytes, self._zero_bytes = False, 0, False

    def _load(self, _value: int, _index: int, data: bytes) -> None:
        if self._loaded_bytes is None or len(data) > 64:
            raise Stall
        self._loaded_bytes += len(data)
        self._zero_bytes = data == bytes(2)

    def _end_configuration(self) -> None:
        """The first request after a whole image finds the FPGA configured."""
        refused = any(isinstance(fault, FpgaRefused) for fault in self.settings.faults)
        refused |= self.settings.fpga_needs_zero_bytes and not self._zero_bytes
        if self._loaded_bytes is not None and self._loaded_bytes >= self.settings.fpga_image_bytes and not refused:
            self._configured, self._loaded_bytes = True, None

    def _reset(self, _value: int, _index: int, _data: bytes) -> None:
        self.gone = True

    def _status(self, _value: int, _index: int, _size: int) -> bytes:
        scan, settings = self._scanner.scan, self.settings
        bits = (_FPGA_CONFIGURED if self._configured else 0) | (_CONFIGURING if self._loaded_bytes is not None else 0)
        if scan is not None:
            bits |= _RUNNING if scan.running else 0
            bits |= _OVERRUN if scan.overrun else 0
            bits |= settings.pacer_overrun_mask if scan.pacer_overrun else 0
            bits |= settings.scan_done_mask if scan.complete else 0
        return bits.to_bytes(2, "little")

    def bulk_in(self, size: int, timeout_s: float | None) -> bytes:
        """Read scan data, until ``size`` bytes are in, a short packet ends the transfer, or the time is over.

        Args:
            size: bytes at most.
            timeout_s: None: no limit.

        Raises:
            TimedOut: nothing came.
            OverflowError: a packet that is larger than what is left of ``size``.
            Gone: no device.
        """
        deadline_s = self._clock.now_s() + (self.settings.patience_s if timeout_s is None else timeout_s)
        data = bytearray()
        while True:
            with self._lock:
                self._look()
                scan = self._scanner.scan
                packet = scan.next_packet if scan is not None else None
                if scan is not None and packet is not None:
                    if len(packet) > size - len(data):
                        raise OverflowError
                    scan.pop()
                    data += packet
                    if len(packet) < self._max_packet or len(data) == size:
                        return bytes(data)
                    continue
                if self._clock.now_s() >= deadline_s:
                    if data:
                        return bytes(data)
                    raise TimedOut
                at_s = self._scanner.next_packet_s(deadline_s)
            self._clock.advance_to(deadline_s if at_s is None else at_s)
