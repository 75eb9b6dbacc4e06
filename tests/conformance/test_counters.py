"""Every counter of ours keeps the contract."""

import pytest

from protocols.conformance import CounterRig, RigFactory
from protocols.conformance.counter import *  # noqa: F403
from tests.conformance.rigs import (
    ni,
    ni_analog,
    serial_counter,
    simulated_counter,
    simulated_light_meter,
    usb_ctr,
    usb_ctr_with_timer,
)


@pytest.fixture(
    params=[simulated_counter, simulated_light_meter, ni, usb_ctr, usb_ctr_with_timer, serial_counter, ni_analog],
    ids=lambda factory: factory.__name__,
)
def open_rig(request: pytest.FixtureRequest) -> RigFactory[CounterRig]:
    factory: RigFactory[CounterRig] = request.param
    return factory
