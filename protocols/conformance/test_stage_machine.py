"""Any order of calls of a ``LinearStage`` against a model: where it stands, and the motion under way."""

import pytest
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, invariant, precondition, rule

from protocols.conformance.consent import ask_before_moving
from protocols.conformance.rigs import RigFactory, StageRig
from protocols.conformance.spot import Spot, brought_back, near
from protocols.conformance.support import assert_keeps_to_model, error_of
from protocols.errors import DeviceBusy, DeviceTimeout, MotionTooFast, TravelExceeded
from protocols.stage import Motion

_SHARES = st.sampled_from([-1.0, -0.6, -0.2, 0.2, 0.6, 1.0])
"""Parts of the distance to either side of the middle: never so near to each other that a move is over at once."""


class StageMachine(RuleBasedStateMachine):
    """Calls, legal and illegal, and what they must answer."""

    def __init__(self, rig: StageRig) -> None:
        super().__init__()
        self.rig = rig
        self.stage = rig.open().__enter__()
        self.spot = Spot(self.stage, rig)
        self.slow = self.spot.but(velocity_mm_s=self.spot.profile.velocity_mm_s / 5)
        self.stage.move_to(self.spot.middle_mm, self.spot.profile).wait()
        self.at_mm = self.spot.middle_mm
        self.motion: Motion | None = None

    @rule(share=_SHARES)
    def move_to(self, share: float) -> None:
        """Starts when the stage stands."""
        self._begin(self.spot.middle_mm + share * self.spot.reach_mm, relative=False)

    @rule(share=_SHARES)
    def move_by(self, share: float) -> None:
        """Starts when the stage stands, from where it stands."""
        self._begin(self.spot.middle_mm + share * self.spot.reach_mm, relative=True)

    @rule()
    def move_too_far_or_too_fast(self) -> None:
        """Is refused, whether the stage stands or not."""
        with pytest.raises((TravelExceeded, DeviceBusy)):
            self.stage.move_to(self.spot.travel_mm[1] + 1.0, self.slow)
        with pytest.raises((MotionTooFast, DeviceBusy)):
            self.stage.move_to(
                self.spot.middle_mm, self.spot.but(velocity_mm_s=1.01 * self.spot.limits.max_velocity_mm_s)
            )

    @precondition(lambda self: self.motion is not None)
    @rule()
    def wait(self) -> None:
        """Arrives."""
        assert self.motion is not None
        end = self.motion.wait()
        assert self.motion.done
        assert near(end.reported_mm, self.motion.target_mm, self.rig.tolerance_mm)
        self.at_mm, self.motion = self.motion.target_mm, None

    @precondition(lambda self: self.motion is not None)
    @rule()
    def wait_in_vain(self) -> None:
        """Times out, unless the move is over by then."""
        assert self.motion is not None
        try:
            self.motion.wait(0.01)
        except DeviceTimeout:
            return
        self.wait()

    @rule()
    def stop(self) -> None:
        """Is always allowed; a motion that it ends says so."""
        self.stage.stop()
        if self.motion is not None:
            motion, self.motion = self.motion, None
            assert not isinstance(error_of(motion.wait), DeviceTimeout)
            self.at_mm = self.stage.position().reported_mm

    @invariant()
    def stands_or_moves(self) -> None:
        """The device and the model agree."""
        position, slack_mm = self.stage.position(), self.rig.tolerance_mm
        if self.motion is None:
            assert near(position.reported_mm, self.at_mm, slack_mm)
            assert not position.predicted
        else:
            low, high = sorted((self.at_mm, self.motion.target_mm))
            assert low - slack_mm <= position.reported_mm <= high + slack_mm
            assert near(position.commanded_mm, self.motion.target_mm, slack_mm)

    def teardown(self) -> None:
        """Close the device, in whatever state it is."""
        self.stage.__exit__(None, None, None)

    def _begin(self, target_mm: float, *, relative: bool) -> None:
        under_way = self.motion is not None and not self.motion.done
        if under_way:
            with pytest.raises(DeviceBusy):
                self._move(target_mm, relative=relative)
            return
        if self.motion is not None:
            self.wait()
        if not near(target_mm, self.at_mm, self.rig.tolerance_mm):
            self.motion = self._move(target_mm, relative=relative)
            assert near(self.motion.target_mm, target_mm, 2 * self.rig.tolerance_mm)

    def _move(self, target_mm: float, *, relative: bool) -> Motion:
        if relative:
            return self.stage.move_by(target_mm - self.at_mm, self.slow)
        return self.stage.move_to(target_mm, self.slow)


def test_any_order_of_calls_is_answered_as_the_protocol_says(
    open_rig: RigFactory[StageRig], pytestconfig: pytest.Config
) -> None:
    with open_rig() as opened:
        ask_before_moving(opened, pytestconfig)
        with brought_back(opened) as rig:
            assert_keeps_to_model(lambda: StageMachine(rig))
