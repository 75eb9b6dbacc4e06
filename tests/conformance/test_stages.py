"""Every stage of ours keeps the contract."""

import pytest

from protocols.conformance import RigFactory, StageRig
from protocols.conformance.stage import *  # noqa: F403
from tests.conformance.rigs import grbl, mc600, mute_mc600, sc300, simulated_stage, talkative_sc300, zaber


@pytest.fixture(
    params=[simulated_stage, mc600, sc300, mute_mc600, talkative_sc300, zaber, grbl],
    ids=lambda factory: factory.__name__,
)
def open_rig(request: pytest.FixtureRequest) -> RigFactory[StageRig]:
    factory: RigFactory[StageRig] = request.param
    return factory
