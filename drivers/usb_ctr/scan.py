"""A running scan of a USB-CTR board, from the first packet to the last."""

from drivers.h10682.detector import NAME
from drivers.h10682.handover import Handover, bins_per_block, collect
from drivers.usb_ctr import codec
from drivers.usb_ctr.board import UsbCtrBoard
from drivers.usb_ctr.codec import FIFO_WORDS, MAX_COUNT_RATE_HZ, Scan
from drivers.usb_ctr.first_sample import check_first_sample
from drivers.usb_ctr.packets import packets_of
from drivers.usb_ctr.settings import EdgeTimer, UsbCtrSettings
from protocols import (
    Clock,
    CountBlock,
    CounterOverrun,
    CounterReport,
    CounterRun,
    KinopixError,
    ProtocolViolation,
    TimingFault,
)

_LONGEST_BIN = 4
"""A bin may grow to so many periods, by lost edges, before a 16-bit count could wrap."""


class UsbCtrScan:
    """The board from arming to disarming."""

    def __init__(self, run: CounterRun, settings: UsbCtrSettings, board: UsbCtrBoard, clock: Clock) -> None:
        """Configure counters and timer, and start the scan; after an error the board is stopped again."""
        self._run = run
        self._settings = settings
        self._board = board
        self._clock = clock
        self._scan = _scan(run, settings)
        self._packets = packets_of(run, self._scan, settings)
        self._rest = b""
        timer = settings.edge_timer
        self._tick_s = timer.tick_s if timer else run.period_s
        self._handover = Handover(run.n_bins, timer.tick_s if timer else None)
        self._samples = 0
        try:
            self._configure(timer)
            if self._packets.complete and settings.sync_counter is not None:
                check_first_sample(
                    board, self._scan, clock, sync_counter=settings.sync_counter, first_samples=settings.first_samples
                )
            board.start_scan(self._scan, samples=self._packets.samples, packet_words=self._packets.words)
        except BaseException:
            self._stop()
            raise

    def read(self, timeout_s: float) -> CountBlock:
        """Hand over the bins that have closed; as ``PhotonCounter.read``."""
        return collect(self._handover, self._poll, run=self._run, clock=self._clock, timeout_s=timeout_s)

    def finish(self) -> CounterReport:
        """Count the surplus edges, stop the board; what fails becomes a note."""
        notes: list[str] = []
        edges_seen = self._edges_seen(notes)
        notes += self._handover.notes  # only now, for the last packets may have brought the fault
        if self._settings.edge_timer is None:
            notes.append("no edge times: the board does not give them unless edge_timer is wired and set")
        notes.extend(self._stop())
        return CounterReport(bins_closed=self._handover.handed_over, edges_seen=edges_seen, notes=tuple(notes))

    def _configure(self, timer: EdgeTimer | None) -> None:
        settings = self._settings
        falling = settings.photon_edge == "falling"
        self._board.ask(codec.count_and_clear(settings.counter, settings.debounce_code, falling=falling))
        if settings.sync_counter is not None:
            self._board.ask(codec.count_on(settings.sync_counter, settings.debounce_code))
        if timer is not None:
            self._board.ask(codec.count_and_clear(timer.counter, settings.debounce_code))
            self._board.ask(codec.timer_parameters(timer.timer, timer.period_ticks))
            self._board.ask(codec.timer_control(timer.timer, on=True))

    def _poll(self, _least: int) -> None:
        """Take in one block of packets, then see whether the board is still well: it tells of an overrun only when asked."""
        try:
            self._drain(bins_per_block(self._run) + 1)
            if self._all_in:
                return
            status = self._board.status()
            if status.overrun or status.scan_done(self._settings.scan_done_mask):
                self._drain(FIFO_WORDS)
                if not self._all_in:
                    self._handover.fail(self._overrun() if status.overrun else self._ended())
        except KinopixError as error:
            self._handover.fail(self._overrun() if self._overran() else error)

    @property
    def _all_in(self) -> bool:
        """Whether the scan has given all the samples that it was started for."""
        return self._packets.complete and self._samples >= self._packets.samples

    def _overran(self) -> bool:
        """Whether an overrun is behind a transfer that failed; False where the board does not answer."""
        try:
            return self._board.status().overrun
        except KinopixError:
            return False

    def _drain(self, most: int) -> bool:
        """Read up to ``most`` packets that are there; True where there are no more. What was read is kept in any case."""
        data = bytearray()
        try:
            for _ in range(most):
                packet = self._board.packet()
                if not packet:
                    return True
                data += packet
                if len(packet) % 2:
                    raise ProtocolViolation(
                        device=NAME,
                        saw=f"a packet of {len(packet)} bytes",
                        expected="whole words of 2 bytes",
                        remedy="look at the USB cable and hub; record again",
                    )
            return False
        finally:
            self._take_in(bytes(data))

    def _take_in(self, data: bytes) -> None:
        """Keep whole samples; a packet may end inside one, which the next packet then completes."""
        counts, self._rest = codec.decode(self._scan, self._rest + data)
        drop = max(0, self._settings.first_samples - self._samples)
        self._samples += len(counts)
        ticks = counts[drop:, 1].astype("int64") if len(self._scan.counters) > 1 else None
        if ticks is not None and not ticks.all():
            ticks = ticks[: int(ticks.argmin())]
            self._handover.fail(self._no_ticks())
        self._handover.add(counts[drop:, 0], ticks)

    def _edges_seen(self, notes: list[str]) -> int | None:
        sync_counter = self._settings.sync_counter
        try:
            dry = self._drain(FIFO_WORDS)
            overrun = self._board.status().overrun
            counted = (
                None if sync_counter is None else codec.parse_count(self._board.ask(codec.ask_count(sync_counter)))
            )
        except KinopixError as error:
            notes.append(f"surplus sync edges are unknown: {error}")
            return None
        if counted is not None:
            notes += self._kept_back(counted)
            return counted
        if overrun or not dry:
            notes.append("surplus sync edges are unknown: " + ("the board overran" if overrun else "they still come"))
            return None
        return max(0, self._samples + 1 - self._settings.first_samples) if self._samples else 0

    def _kept_back(self, edges: int) -> list[str]:
        """Say what a scan that was cut short kept: the board sends its last packet only when all samples are in."""
        missing = edges - 1 + self._settings.first_samples - self._samples
        if not self._packets.complete or self._all_in or missing <= 0:
            return []
        return [
            f"{missing} samples stayed on the board, which sends the last packet of a scan only when it is complete"
        ]

    def _stop(self) -> list[str]:
        notes: list[str] = []
        timer = self._settings.edge_timer
        try:
            self._board.stop_scan()
            if timer is not None:
                self._board.ask(codec.timer_control(timer.timer, on=False))
        except KinopixError as error:
            notes.append(f"while disarming: {error}")
        return notes

    def _overrun(self) -> CounterOverrun:
        return CounterOverrun(
            device=NAME,
            saw=f"status bit 2 (overrun) after {self._samples} samples",
            expected="every sample read in time",
            remedy="give the board its own USB port, keep the computer free, or lower pattern_rate_hz",
        )

    def _no_ticks(self) -> TimingFault:
        return TimingFault(
            device=NAME,
            saw="two sync edges without a tick of the edge timer between them",
            expected=f"some {self._run.period_s / self._tick_s:.0f} ticks a pattern",
            remedy="wire the timer output to the counter input that edge_timer names, or leave edge_timer out of bench.toml",
        )

    def _ended(self) -> TimingFault:
        mask = self._settings.scan_done_mask
        return TimingFault(
            device=NAME,
            saw=f"a scan that ended by itself (status bit {mask:#04x}) after {self._samples} samples",
            expected="a scan that goes on until it is stopped",
            remedy="record again; if it comes back, run the self-test and correct scan_done_mask in bench.toml",
        )


def _scan(run: CounterRun, settings: UsbCtrSettings) -> Scan:
    highest_count = _LONGEST_BIN * run.period_s * MAX_COUNT_RATE_HZ
    words = 1 if highest_count <= 0xFFFF else 2
    counters = (settings.counter,) if settings.edge_timer is None else (settings.counter, settings.edge_timer.counter)
    return Scan(counters, words)
