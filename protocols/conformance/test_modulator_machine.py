"""Any order of calls of a ``PatternModulator`` against a model of three facts: what is loaded, what was started, what plays."""

from typing import Final

import pytest
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from protocols.conformance.patterns import run_s, sequence_for, timing_for
from protocols.conformance.rigs import ModulatorRig, RigFactory
from protocols.conformance.support import assert_keeps_to_model
from protocols.errors import DeviceBusy, DeviceTimeout, PlanError, WrongState

_PICTURE_US: Final = 200_000
"""So slow that no call but a wait outlasts a run."""


class ModulatorMachine(RuleBasedStateMachine):
    """Calls, legal and illegal, and what they must answer."""

    def __init__(self, rig: ModulatorRig) -> None:
        super().__init__()
        self.rig = rig
        self.modulator = rig.open().__enter__()
        self.limits = self.modulator.limits
        self.timing = timing_for(self.limits, _PICTURE_US)
        self.loaded: int | None = None
        self.started = False
        self.playing = False

    @rule(n_patterns=st.integers(2, 5))
    def load(self, n_patterns: int) -> None:
        """Loads when idle."""
        sequence = sequence_for(self.limits, n_patterns)
        if self.playing:
            with pytest.raises((WrongState, DeviceBusy)):
                self.modulator.load(sequence, self.timing)
        else:
            assert self.modulator.load(sequence, self.timing).picture_time_us == self.timing.picture_time_us
            self.loaded, self.started = n_patterns, False

    @precondition(lambda self: not self.playing and self.loaded is None)
    @rule()
    def load_for_other_mirrors(self) -> None:
        """Is refused, and leaves the device empty."""
        with pytest.raises(PlanError):
            self.modulator.load(sequence_for(self.limits, 3, extra_columns=8), self.timing)

    @rule()
    def start(self) -> None:
        """Starts what is loaded, unless it plays."""
        if self.playing or self.loaded is None:
            with pytest.raises(WrongState):
                self.modulator.start()
        else:
            self.modulator.start()
            self.started = self.playing = True

    @rule()
    def wait(self) -> None:
        """Lets the run end."""
        if not self.started:
            with pytest.raises(WrongState):
                self.modulator.wait(1.0)
        elif self.playing:
            self.modulator.wait(2 * self._run_s() + 1.0)
            self.playing = False
            if self.rig.sync_edges is not None:
                assert len(self.rig.sync_edges()) == (self.loaded or 0) + 1

    @precondition(lambda self: self.playing)
    @rule()
    def wait_in_vain(self) -> None:
        """Times out."""
        with pytest.raises(DeviceTimeout):
            self.modulator.wait(0.001)

    @rule()
    def halt(self) -> None:
        """Is always allowed."""
        self.modulator.halt()
        self.playing = False

    @invariant()
    def runs_as_the_model(self) -> None:
        """The device and the model agree."""
        assert self.modulator.running == self.playing

    def teardown(self) -> None:
        """Close the device, in whatever state it is."""
        self.modulator.__exit__(None, None, None)

    def _run_s(self) -> float:
        return run_s(sequence_for(self.limits, self.loaded or 1), self.timing)


def test_any_order_of_calls_is_answered_as_the_protocol_says(open_rig: RigFactory[ModulatorRig]) -> None:
    with open_rig() as rig:
        assert_keeps_to_model(lambda: ModulatorMachine(rig))
