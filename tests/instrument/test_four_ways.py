"""One plan through simulated devices and through the real drivers on emulators: the same counts, to the bit."""

from pathlib import Path

import numpy as np
import pytest

from instrument.plan import MotionPlan, Plan
from instrument.recording import Recording
from instrument.session import Instrument

BENCHES = Path(__file__).parents[2] / "examples" / "benches"
PLAN = Plan(frames=1666, motion=MotionPlan(velocity_mm_s=25.0, acceleration_mm_s2=50.0))


def recorded(bench: str, folder: Path) -> Recording:
    with Instrument.from_toml(BENCHES / f"{bench}.toml") as opened:
        return opened.run(PLAN, folder / f"{bench}.h5")


@pytest.fixture(scope="module")
def simulated(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    return recorded("simulated", tmp_path_factory.mktemp("simulated"))


@pytest.mark.parametrize("bench", ["alp-ni-mc600", "alp-usbctr-sc300", "mixed", "zaber", "grbl", "serial-counter"])
def test_the_real_drivers_count_what_the_simulated_devices_count(
    bench: str, simulated: Recording, tmp_path: Path
) -> None:
    recording = recorded(bench, tmp_path)
    assert recording.photon_counts
    assert recording.timing is not None
    assert recording.timing.verdict == "good"
    assert recording.timing.bins_received == 9996
    np.testing.assert_array_equal(recording.values, simulated.values)
    assert recording.truth is not None
    assert simulated.truth is not None
    np.testing.assert_array_equal(recording.truth.displacement_px, simulated.truth.displacement_px)
