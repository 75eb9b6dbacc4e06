"""What each test of a ``LinearStage`` is given: the rig, the stage in the middle of its spot, and the spot."""

from collections.abc import Iterator

import pytest

from protocols.conformance.consent import ask_before_moving
from protocols.conformance.rigs import RigFactory, StageRig
from protocols.conformance.spot import Spot, brought_back
from protocols.stage import LinearStage


@pytest.fixture
def rig(open_rig: RigFactory[StageRig], pytestconfig: pytest.Config) -> Iterator[StageRig]:
    """What the device stands on; the stage is brought back after the test."""
    with open_rig() as opened:
        ask_before_moving(opened, pytestconfig)
        with brought_back(opened) as rig:
            yield rig


@pytest.fixture
def stage(rig: StageRig) -> Iterator[LinearStage]:
    """An open device, with room on both sides."""
    with rig.open() as stage:
        spot = Spot(stage, rig)
        stage.move_to(spot.middle_mm, spot.profile).wait()
        yield stage


@pytest.fixture
def spot(rig: StageRig, stage: LinearStage) -> Spot:
    """Where and how fast the stage moves in a test."""
    return Spot(stage, rig)
