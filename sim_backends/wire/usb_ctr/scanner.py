"""Scanning against the bench: the scan requests (0x20 to 0x24), and the moments at which scans are taken."""

import numpy as np

from sim_backends.bench import OpticalBench
from sim_backends.wire.seen_edges import SeenEdges
from sim_backends.wire.usb_ctr.counters import Counters, Moments
from sim_backends.wire.usb_ctr.requests import Read, Stall, Write, exactly
from sim_backends.wire.usb_ctr.scan import KEEP_COUNTERS, Scan, Start
from sim_backends.wire.usb_ctr.settings import UsbCtrEmulatorSettings
from sim_backends.wire.usb_ctr.timers import BASE_HZ

_MOST_ELEMENTS = 33
_NOT_A_COUNTER = 0x20


class Scanner:
    """What the device sees of edges and photons from power-up on, and the scan that it takes of them."""

    def __init__(self, settings: UsbCtrEmulatorSettings, bench: OpticalBench, counters: Counters) -> None:
        self.scan: Scan | None = None
        self._settings = settings
        self._clock = bench.clock
        self._edges = SeenEdges(bench, bench.clock.now_s())
        self._counters = counters
        self._photons = 0
        self._edges_seen = 0
        self._elements = b""
        self._list = bytes(_MOST_ELEMENTS)
        self._fresh = False
        self.writes: dict[int, Write] = {
            0x20: self._configure,
            0x21: self._start,
            0x22: self._stop,
            0x23: self._clear,
            0x24: self._flush,
        }
        self.reads: dict[int, Read] = {0x20: self._configuration}

    def now(self) -> Moments:
        """What has come until now, as far as it was looked at."""
        return Moments(np.array([self._clock.now_s()]), np.array([self._photons]), np.array([self._edges_seen]))

    @property
    def scanning(self) -> bool:
        """Whether a scan runs."""
        return self.scan is not None and self.scan.running

    def _configure(self, _value: int, index: int, data: bytes) -> None:
        if self.scanning or index >= _MOST_ELEMENTS:
            raise Stall
        elements = exactly(data, _MOST_ELEMENTS)[: index + 1]
        if any(not element & _NOT_A_COUNTER and element & 0x07 >= len(self._counters) for element in elements):
            raise Stall
        self._elements, self._list = elements, data

    def _configuration(self, _value: int, _index: int, _size: int) -> bytes:
        if self.scanning:
            raise Stall
        return self._list

    def _start(self, _value: int, _index: int, data: bytes) -> None:
        if self.scanning or not self._elements:
            raise Stall
        start = Start.parse(exactly(data, 14))
        now = self.now()
        if not start.options & KEEP_COUNTERS:
            for index in range(len(self._counters)):
                self._counters.put(index, 0, now)
        self.scan = Scan(self._settings, self._elements, start, float(now.time_s[0]))
        self._fresh = True
        if self._settings.reads_at_start:
            self.scan.feed(now, self._counters.latch)

    def _stop(self, _value: int, _index: int, _data: bytes) -> None:
        if self.scan is not None:
            self.scan.stop()

    def _clear(self, _value: int, _index: int, _data: bytes) -> None:
        if self.scan is not None:
            self.scan.clear()

    def _flush(self, value: int, _index: int, _data: bytes) -> None:
        for _ in range(value):
            if self.scan is not None and self.scan.next_packet is not None:
                self.scan.pop()

    def look(self) -> None:
        """Take in what happened until now."""
        now_s = self._clock.now_s()
        time_s, photons = self._edges.take(now_s)
        paced = self.scan is not None and self.scan.running and self.scan.start.pacer_period > 0
        if len(time_s) == 0 and not paced:
            return
        if len(time_s) and self._fresh:
            photons[0] += self._settings.counts_before_first_edge
            self._fresh = False
        at = Moments(
            time_s, self._photons + np.cumsum(photons), self._edges_seen + 1 + np.arange(len(time_s), dtype=np.int64)
        )
        if self.scan is not None and self.scan.running:
            self.scan.feed(self._paced(self.scan, at, now_s) if paced else at, self._counters.latch)
        self._photons += int(photons.sum())
        self._edges_seen += len(time_s)

    def _paced(self, scan: Scan, at: Moments, now_s: float) -> Moments:
        """The moments of the internal pacer, with what had come by then. Scan 0 is taken at the start, and holds nothing."""
        period_s = (scan.start.pacer_period + 1) / BASE_HZ
        last = int((now_s - scan.started_s) / period_s + 1e-6)
        time_s = scan.started_s + period_s * np.arange(scan.done, last + 1, dtype=np.float64)
        before = np.searchsorted(at.time_s, time_s, side="right")
        photons = np.concatenate([[self._photons], at.photons])[before]
        return Moments(time_s, photons, (self._edges_seen + before).astype(np.int64))

    def next_packet_s(self, until_s: float) -> float | None:
        """When the next packet may be there; None: not until ``until_s``."""
        scan = self.scan
        if scan is None or not scan.running:
            return None
        scans = scan.scans_to_packet()
        if scan.start.pacer_period == 0:
            return self._edges.time_of(scans, until_s)
        at_s = scan.started_s + (scan.done + scans - 1) * (scan.start.pacer_period + 1) / BASE_HZ
        return at_s if at_s <= until_s else None
