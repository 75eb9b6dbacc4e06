"""Every modulator of ours keeps the contract."""

import pytest

from protocols.conformance import ModulatorRig, RigFactory
from protocols.conformance.modulator import *  # noqa: F403
from tests.conformance.rigs import dlp6500, dlp7000, dlp7000_without_table, dlp9000, simulated_modulator

RIGS = [simulated_modulator, dlp7000, dlp7000_without_table, dlp6500, dlp9000]


@pytest.fixture(params=RIGS, ids=lambda factory: factory.__name__)
def open_rig(request: pytest.FixtureRequest) -> RigFactory[ModulatorRig]:
    factory: RigFactory[ModulatorRig] = request.param
    return factory
