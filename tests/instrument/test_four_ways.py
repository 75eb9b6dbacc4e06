"""One plan through simulated devices and through the real drivers on emulators: the same counts, to the bit."""

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

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


@cache
def _on_simulated_devices(scene: str) -> Recording:
    """The run on simulated devices before a scene, which is a ``[scene]`` table as text."""
    devices = "".join(f'[{role}]\ndriver = "simulated"\n' for role in ("modulator", "counter", "stage"))
    with TemporaryDirectory() as folder:
        (Path(folder) / "bench.toml").write_text(devices + scene, encoding="utf-8")
        with Instrument.from_toml(Path(folder) / "bench.toml") as opened:
            return opened.run(PLAN, Path(folder) / "run.h5")


@pytest.mark.parametrize("bench", ["alp-ni-mc600", "alp-usbctr-sc300", "mixed", "zaber", "grbl", "serial-counter"])
def test_the_real_drivers_count_what_the_simulated_devices_count(bench: str, tmp_path: Path) -> None:
    text = (BENCHES / f"{bench}.toml").read_text(encoding="utf-8")
    simulated = _on_simulated_devices(text[text.index("[scene]") :])
    recording = recorded(bench, tmp_path)
    assert recording.photon_counts
    assert recording.timing is not None
    assert recording.timing.verdict == "good"
    assert recording.timing.bins_received == 9996
    np.testing.assert_array_equal(recording.values, simulated.values)
    assert recording.truth is not None
    assert simulated.truth is not None
    np.testing.assert_array_equal(recording.truth.displacement_px, simulated.truth.displacement_px)


def test_a_dlpc900_shows_what_a_simulated_modulator_of_its_size_shows(tmp_path: Path) -> None:
    """396 patterns and the guard of the 400 that it can play, 9,009 a second."""
    plan = PLAN.model_copy(update={"frames": 66, "pattern_rate_hz": 9000.0, "image_size": 64})
    text = (BENCHES / "dlpc900.toml").read_text()
    for name in ("dlpc900", "simulated"):
        driver = 'driver = "dlpc900"\ntransport = "dlpc900-emulator"'
        other = 'driver = "simulated"\ncolumns = 1920\nrows = 1080'
        (tmp_path / f"{name}.toml").write_text(text if name == "dlpc900" else text.replace(driver, other))
    recordings: list[Recording] = []
    for name in ("dlpc900", "simulated"):
        with Instrument.from_toml(tmp_path / f"{name}.toml") as opened:
            recordings.append(opened.run(plan, tmp_path / f"{name}.h5"))
    real, simulated = recordings
    assert real.timing is not None
    assert (real.timing.verdict, real.timing.bins_received) == ("good", 396)
    np.testing.assert_array_equal(real.values, simulated.values)


def test_analogue_inputs_give_the_light_to_their_stated_noise(tmp_path: Path) -> None:
    """Volts for the photons of a simulated counter on the same bench; the report of the run states their noise."""
    plan = PLAN.model_copy(update={"frames": 50, "image_size": 32})
    text = (BENCHES / "ni-analog.toml").read_text()
    real = 'driver = "ni-analog"\ntransport = "ni-analog-emulator"\n\n[counter.emulator]\nnoise_v = 0.002'
    assert real in text
    recordings: list[Recording] = []
    for name, bench in (("analog", text), ("counted", text.replace(real, 'driver = "simulated"'))):
        (tmp_path / f"{name}.toml").write_text(bench)
        with Instrument.from_toml(tmp_path / f"{name}.toml") as opened:
            recordings.append(opened.run(plan, tmp_path / f"{name}.h5"))
    volts, counts = recordings
    assert volts.timing is not None
    assert volts.timing.verdict == "good"
    assert not volts.photon_counts
    (note,) = (note for note in volts.timing.notes if "noise of one" in note)
    stated_v = float(note.split("noise of one ")[1].split(" V")[0])
    assert stated_v == pytest.approx(0.002 / np.sqrt(17), rel=0.1)  # 25 samples a picture, 8 left out
    error_v = volts.values - 1e-3 * counts.values
    assert np.sqrt(np.mean(error_v**2)) == pytest.approx(stated_v, rel=0.15)
