"""Any order of calls of a ``PhotonCounter`` against a model: bins asked for, edges given, bins handed over."""

from typing import Final

import pytest
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, precondition, rule

from protocols.conformance.rigs import CounterRig, RigFactory
from protocols.conformance.support import assert_keeps_to_model
from protocols.counter import CounterRun
from protocols.errors import WrongState

_PERIOD_S: Final = 1e-3
_MOST_EDGES: Final = 40


class CounterMachine(RuleBasedStateMachine):
    """Calls, legal and illegal, and what they must answer."""

    def __init__(self, rig: CounterRig) -> None:
        super().__init__()
        self.rig = rig
        self.counter = rig.open().__enter__()
        self.asked: int | None = None
        self.edges = 0
        self.bins = 0

    @property
    def closed(self) -> int:
        """Bins that will have closed when all edges have come."""
        return min(self.asked or 0, max(0, self.edges - 1))

    @rule(n_bins=st.integers(1, 30), latency_ms=st.sampled_from([1, 5, 50]))
    def arm(self, n_bins: int, latency_ms: int) -> None:
        """Arms when idle."""
        run = CounterRun(n_bins=n_bins, period_s=_PERIOD_S, latency_s=latency_ms * 1e-3)
        if self.asked is None:
            self.counter.arm(run)
            self.asked, self.edges, self.bins = n_bins, 0, 0
        else:
            with pytest.raises(WrongState):
                self.counter.arm(run)

    @precondition(lambda self: self.asked is not None and self.edges == 0)
    @rule(edges=st.integers(1, _MOST_EDGES))
    def play(self, edges: int) -> None:
        """Gives edges, too few, enough, or too many."""
        assert self.rig.play is not None
        self.rig.play(edges, _PERIOD_S)
        self.edges = edges

    @rule(timeout_ms=st.sampled_from([0, 2, 100]))
    def read(self, timeout_ms: int) -> None:
        """Gives the next bins, never more than have closed."""
        if self.asked is None:
            with pytest.raises(WrongState):
                self.counter.read(timeout_ms * 1e-3)
            return
        block = self.counter.read(timeout_ms * 1e-3)
        assert len(block) == 0 or block.first_bin == self.bins
        self.bins += len(block)
        assert self.bins <= self.closed
        assert len(block) > 0 or timeout_ms < 2 * _MOST_EDGES or self.bins == self.closed

    @rule()
    def read_all(self) -> None:
        """Gives all that have closed, and then nothing."""
        while self.asked is not None:
            block = self.counter.read(2 * _MOST_EDGES * _PERIOD_S)
            self.bins += len(block)
            if len(block) == 0:
                assert self.bins == self.closed
                return

    @rule()
    def disarm(self) -> None:
        """Is always allowed, and tells what was handed over."""
        self.rig.clock.sleep_s(2 * _MOST_EDGES * _PERIOD_S)  # no edge is left over for the next run
        report = self.counter.disarm()
        assert report.bins_closed == (self.bins if self.asked is not None else 0)
        if self.asked is not None and report.edges_seen is not None:
            assert report.edges_seen == self.edges
        self.asked = None

    def teardown(self) -> None:
        """Close the device, in whatever state it is."""
        self.rig.clock.sleep_s(2 * _MOST_EDGES * _PERIOD_S)
        self.counter.__exit__(None, None, None)


def test_any_order_of_calls_is_answered_as_the_protocol_says(open_rig: RigFactory[CounterRig]) -> None:
    with open_rig() as rig:
        if rig.play is None:
            pytest.skip("the rig has no play: nothing gives sync edges")
        assert_keeps_to_model(lambda: CounterMachine(rig))
