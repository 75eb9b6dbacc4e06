"""What each test of a ``PatternModulator`` is given: the rig, and the device."""

from collections.abc import Iterator

import pytest

from protocols.conformance.rigs import ModulatorRig, RigFactory
from protocols.modulator import PatternModulator


@pytest.fixture
def rig(open_rig: RigFactory[ModulatorRig]) -> Iterator[ModulatorRig]:
    """What the device stands on."""
    with open_rig() as rig:
        yield rig


@pytest.fixture
def modulator(rig: ModulatorRig) -> Iterator[PatternModulator]:
    """An open device."""
    with rig.open() as modulator:
        yield modulator
