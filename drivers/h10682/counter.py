"""The counter as the framework sees it, on whichever board: one run at a time, calls out of order refused."""

from collections.abc import Callable
from typing import Protocol, Self

from drivers.h10682.detector import NAME
from protocols import CountBlock, CounterLimits, CounterReport, CounterRun, DeviceIdentity, WrongState


class BoardRun(Protocol):
    """A board from arming to disarming."""

    def read(self, timeout_s: float) -> CountBlock:
        """Hand over the bins that have closed; as ``PhotonCounter.read``."""
        ...

    def finish(self) -> CounterReport:
        """Stop the board and tell what it saw. What fails here becomes a note."""
        ...


def _nothing() -> None:
    """Let go of a board that nothing holds between runs."""


class H10682Counter:
    """A ``PhotonCounter``: an H10682 head on a counter board. One thread reads."""

    def __init__(
        self,
        identity: DeviceIdentity,
        limits: CounterLimits,
        begin: Callable[[CounterRun], BoardRun],
        close: Callable[[], None] = _nothing,
    ) -> None:
        """Take over an open board.

        Args:
            identity: the board and the head.
            limits: the slower of both; every run is held against them.
            begin: arms the board for a run, all of it or nothing, and raises what the board refuses.
            close: gives the board back.
        """
        self._identity = identity
        self._limits = limits
        self._begin = begin
        self._close = close
        self._armed: BoardRun | None = None
        self._closed = False

    @property
    def identity(self) -> DeviceIdentity:
        """Identity of the board and of the head."""
        return self._identity

    @property
    def limits(self) -> CounterLimits:
        """Limits of the slower of head and board."""
        return self._limits

    def arm(self, run: CounterRun) -> None:
        """Arm the board for ``run``; after an error it is not armed.

        Raises:
            WrongState: already armed, or closed.
            PlanError: faster or longer than the limits allow.
            DeviceBusy: another program or task holds what the run needs.
            DeviceRefused: the board does not take the settings.
        """
        if self._armed is not None or self._closed:
            raise WrongState(
                device=NAME,
                saw=f"arm on a counter that is {'closed' if self._closed else 'armed'}",
                expected="an open counter that is not armed",
                remedy="open the bench again" if self._closed else "disarm it first",
            )
        self._limits.check_run(run, NAME)
        self._armed = self._begin(run)

    def read(self, timeout_s: float) -> CountBlock:
        """Hand over the bins that have closed. See ``PhotonCounter.read``.

        Raises:
            CounterOverrun: the board or the host's buffer lost samples.
            TimingFault: the sync line is not clean, or the board's own figures contradict each other.
            ProtocolViolation: the board sent what cannot be samples.
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
        """Stop the board and tell how many sync edges it saw. What fails here becomes a note."""
        run, self._armed = self._armed, None
        return CounterReport(bins_closed=0) if run is None else run.finish()

    def __enter__(self) -> Self:
        """Give the open counter."""
        return self

    def __exit__(self, *exc: object) -> None:
        """Disarm and let go of the board, even if disarming fails."""
        self._closed = True
        try:
            self.disarm()
        finally:
            self._close()
