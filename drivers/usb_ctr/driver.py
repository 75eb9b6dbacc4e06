"""H10682 on a Measurement Computing USB-CTR04 or USB-CTR08, by the board's own USB protocol.

The modulator's sync on CLKI samples a counter that is cleared by each sample, so that every sample is the count of one bin
and nothing is subtracted. Each sample comes in a packet of its own, so a short run delivers its last bin too. Fact sheet
h10682-daq, section 5.
"""

from types import TracebackType
from typing import Self

from drivers.h10682.detector import NAME, check_run, counter_limits
from drivers.usb_ctr.board import UsbCtrBoard
from drivers.usb_ctr.scan import UsbCtrScan
from drivers.usb_ctr.self_test import SelfTest, self_test
from drivers.usb_ctr.settings import UsbCtrSettings
from protocols import (
    Clock,
    CountBlock,
    CounterLimits,
    CounterReport,
    CounterRun,
    DeviceIdentity,
    InputError,
    WrongState,
)


class UsbCtrPhotonCounter:
    """A ``PhotonCounter``. Without an edge timer it gives no edge times: the board has no timebase that a counter could count."""

    def __init__(self, settings: UsbCtrSettings, board: UsbCtrBoard, clock: Clock, *, simulated: bool = False) -> None:
        """Take over an open board whose FPGA is loaded.

        Raises:
            InputError: the settings name a counter that the board does not have.
        """
        self._settings = settings
        self._board = board
        self._clock = clock
        _check_counters(settings, board)
        self._identity = DeviceIdentity(
            name=NAME,
            vendor="Measurement Computing",
            model=f"{board.model} with {settings.head.model}",
            serial=board.serial,
            firmware=f"FPGA {board.fpga_version()}",
            driver="pyusb",
            simulated=simulated,
        )
        self._armed: UsbCtrScan | None = None
        self._closed = False

    @property
    def identity(self) -> DeviceIdentity:
        """The board and the head."""
        return self._identity

    @property
    def limits(self) -> CounterLimits:
        """The slower of head and counter."""
        settings = self._settings
        return counter_limits(
            settings.head,
            counter_dead_time_s=settings.counter_dead_time_s,
            max_sync_rate_hz=settings.max_sync_rate_hz,
            edge_time_resolution_s=settings.edge_timer.tick_s if settings.edge_timer else None,
        )

    def arm(self, run: CounterRun) -> None:
        """Configure the counters and start the scan.

        Raises:
            WrongState: already armed, or closed.
            PlanError: more sync edges a second than allowed.
            DeviceRefused: the board stalls a request.
        """
        self._refuse_unless_idle("arm")
        check_run(NAME, run, self.limits)
        self._armed = UsbCtrScan(run, self._settings, self._board, self._clock)

    def read(self, timeout_s: float) -> CountBlock:
        """Hand over the bins that have closed. See ``PhotonCounter.read``.

        Raises:
            CounterOverrun: the board lost samples.
            TimingFault: the scan ended by itself.
            ProtocolViolation: a packet that is not whole samples.
            DeviceDisconnected: the board is gone.
            WrongState: not armed.
        """
        if self._armed is None:
            raise WrongState(
                device=NAME,
                saw="read on a counter that is not armed",
                expected="an armed counter",
                remedy="arm it first",
            )
        return self._armed.read(timeout_s)

    def disarm(self) -> CounterReport:
        """Stop the scan and tell how many sync edges it saw. What fails here becomes a note."""
        scan, self._armed = self._armed, None
        return CounterReport(bins_closed=0) if scan is None else scan.finish()

    def self_test(self, timer: int = 0) -> SelfTest:
        """Find the debounce code that counts and the bit that means "scan done": wire TMR ``timer`` to the photon input first.

        Raises:
            WrongState: armed, or closed.
            DeviceTimeout: a paced scan of the board gives no samples.
        """
        self._refuse_unless_idle("self_test")
        return self_test(self._board, self._clock, counter=self._settings.counter, timer=timer)

    def __enter__(self) -> Self:
        """Give the open counter."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Disarm and let go of the board."""
        self._closed = True
        try:
            self.disarm()
        finally:
            self._board.close()

    def _refuse_unless_idle(self, call: str) -> None:
        if self._armed is not None or self._closed:
            raise WrongState(
                device=NAME,
                saw=f"{call} on a counter that is {'closed' if self._closed else 'armed'}",
                expected="an open counter that is not armed",
                remedy="open the bench again" if self._closed else "disarm it first",
            )


def _check_counters(settings: UsbCtrSettings, board: UsbCtrBoard) -> None:
    timer = settings.edge_timer
    counters = [settings.counter] if timer is None else [settings.counter, timer.counter]
    if max(counters) >= board.n_counters or len(set(counters)) < len(counters):
        raise InputError(
            device=NAME,
            saw=f"counters {counters}",
            expected=f"different counters from 0 to {board.n_counters - 1} on a {board.model}",
            remedy="correct counter and edge_timer in bench.toml",
        )
