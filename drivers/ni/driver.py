"""H10682 on a National Instruments counter board.

Two buffered edge counts share the modulator's sync as sample clock: one counts photons, the other an onboard timebase, so
every sync edge has a hardware time. Both run continuously, so surplus edges are seen. Fact sheet h10682-daq, sections 2, 4.
"""

from types import TracebackType
from typing import Self

from drivers.h10682.detector import NAME, check_run, counter_limits
from drivers.ni.errors import NiFault, typed_error
from drivers.ni.run import NiRun
from drivers.ni.settings import NiSettings
from drivers.ni.tasks import NiBoardFacts, NiSystem
from protocols import (
    Clock,
    CountBlock,
    CounterLimits,
    CounterReport,
    CounterRun,
    DeviceIdentity,
    DeviceRefused,
    WrongState,
)


class NiPhotonCounter:
    """A ``PhotonCounter``. One thread reads; the board's two counters belong to it from ``arm`` to ``disarm``."""

    def __init__(self, settings: NiSettings, system: NiSystem, clock: Clock, *, simulated: bool = False) -> None:
        """Ask the board who it is and whether it can count on an external clock.

        Raises:
            DriverUnavailable: no such board.
            DeviceRefused: the board cannot do buffered edge counting.
        """
        self._settings = settings
        self._system = system
        self._clock = clock
        try:
            board = system.board(settings.device)
            version = system.version
        except NiFault as fault:
            raise typed_error(fault, device=NAME) from fault
        _check_board(board)
        self._identity = DeviceIdentity(
            name=NAME,
            vendor="NI",
            model=f"{board.product} with {settings.head.model}",
            serial=board.serial,
            driver=version,
            simulated=simulated or board.simulated,
        )
        self._armed: NiRun | None = None
        self._closed = False

    @property
    def identity(self) -> DeviceIdentity:
        """The board and the head."""
        return self._identity

    @property
    def limits(self) -> CounterLimits:
        """The slower of head and counter; edge times in steps of the timebase."""
        settings = self._settings
        return counter_limits(
            settings.head,
            counter_dead_time_s=settings.counter_dead_time_s,
            max_sync_rate_hz=settings.max_sync_rate_hz,
            edge_time_resolution_s=1 / settings.timebase_hz if settings.edge_counter else None,
        )

    def arm(self, run: CounterRun) -> None:
        """Reserve, configure and start the counters: all of them or none.

        Raises:
            WrongState: already armed, or closed.
            PlanError: more sync edges a second than allowed.
            DeviceBusy: another task holds a counter or a line.
            DeviceRefused: the board does not take the settings.
        """
        if self._armed is not None or self._closed:
            state = "closed" if self._closed else "armed"
            raise WrongState(
                device=NAME, saw=f"arm on a counter that is {state}", expected="an open counter that is not armed",
                remedy="open the bench again" if self._closed else "disarm it first",
            )  # fmt: skip
        check_run(NAME, run, self.limits)
        self._armed = NiRun(run, self._settings, self._system, self._clock)

    def read(self, timeout_s: float) -> CountBlock:
        """Hand over the bins that have closed. See ``PhotonCounter.read``.

        Raises:
            CounterOverrun: samples were lost on the board or in the host's buffer.
            TimingFault: the sync line is not clean, or one counter has stored fewer samples than the other.
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
        """Stop and free the counters, and tell how many sync edges they saw. What fails here becomes a note."""
        run, self._armed = self._armed, None
        return CounterReport(bins_closed=0) if run is None else run.finish()

    def __enter__(self) -> Self:
        """Give the open counter."""
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        """Disarm and let go."""
        self._closed = True
        self.disarm()


def _check_board(board: NiBoardFacts) -> None:
    if not board.sample_clocked_counting or board.counter_bits != 32:
        raise DeviceRefused(
            NAME,
            code="ci_samp_clk_supported, ci_max_size",
            saw=f"a {board.product} with {board.counter_bits}-bit counters, "
            + ("sampled" if board.sample_clocked_counting else "which cannot be sampled")
            + " by a clock",
            expected="32-bit counters with a sample clock",
            remedy="use a board that has them, such as one of the X series",
        )
