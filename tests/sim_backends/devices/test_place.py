"""Where simulated devices stand."""

import pytest

from protocols import BenchContext, InputError
from sim_backends.bench import OpticalBench, SceneSettings
from sim_backends.devices.place import place


def test_a_simulated_device_stands_on_the_optical_bench() -> None:
    bench = OpticalBench(SceneSettings())
    assert place(BenchContext(scene=bench), "dmd") is bench


def test_a_transport_that_nobody_would_use_is_refused() -> None:
    context = BenchContext(scene=OpticalBench(SceneSettings()), transport=object())
    with pytest.raises(InputError, match="dmd: saw a transport for a simulated device"):
        place(context, "dmd")
