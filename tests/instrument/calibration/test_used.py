"""What was calibrated is what runs and their analysis take."""

from datetime import UTC, datetime
from pathlib import Path

import pytest

from instrument.config import (
    CalibratedDevice,
    Calibration,
    DeadTimeKind,
    DetectorSection,
    LightTable,
    Measured,
    MirrorsSection,
    load_bench,
    write_calibration,
)
from instrument.measurement import LightModel, Measurement
from instrument.plan import Plan
from instrument.session import Instrument
from instrument.storage import open_recording
from tests.support.benches import SMALL, bench_toml

NOW = datetime.now(UTC)
DETECTOR = DetectorSection(
    date=NOW,
    dark_rate_hz=Measured(value=700.0, sigma=10.0),
    dead_time_s=Measured(value=3e-8, sigma=1e-10),
    dead_time_kind="paralyzable",
)
MIRRORS = MirrorsSection(
    date=NOW,
    picture_time_s=50e-6,
    leak=Measured(value=0.04, sigma=0.001),
    early=Measured(value=0.0, sigma=0.001),
    edge_loss=Measured(value=0.02, sigma=0.002),
    late_s=Measured(value=2e-6, sigma=1e-7),
)


def with_mirrors(mirrors: MirrorsSection) -> Calibration:
    return Calibration(bench={}, mirrors=mirrors)


def calibrated(folder: Path, light: str = "") -> Path:
    """A bench.toml that names a calibration of detector and mirrors."""
    bench = bench_toml(folder, 'noise = { kind = "poisson", peak_counts = 100, dead_time_s = 2e-8, seed = 1 }')
    with Instrument.from_toml(bench) as opened:
        devices = {role: CalibratedDevice.of(identity) for role, identity in opened.devices.identities().items()}
    write_calibration(folder / "calibration.toml", Calibration(bench=devices, detector=DETECTOR, mirrors=MIRRORS))
    bench.write_text('calibration = "calibration.toml"\n' + bench.read_text() + light)
    return bench


def test_a_run_keeps_the_calibrated_dead_time_dark_rate_leak_and_edge_loss(tmp_path: Path) -> None:
    plan = SMALL.model_copy(update={"motion": None, "pattern_rate_hz": 10_000.0})
    with Instrument.from_toml(calibrated(tmp_path)) as bench:
        bench.run(plan, tmp_path / "run.h5")
    recording = open_recording(tmp_path / "run.h5")
    assert recording.dead_time_s == pytest.approx(3e-8)
    assert recording.dark_rate_hz == pytest.approx(700)
    assert recording.light.dead_time_kind == "paralyzable"
    light = Measurement.of(recording).light
    assert (light.leak.value, light.leak.sigma) == pytest.approx((0.02, 0.0005))  # twice the picture time
    assert (light.edge_loss.value, light.edge_loss.sigma) == pytest.approx((0.02, 0.002))
    assert light.leak.source == light.edge_loss.source == "calibrated"
    assert not light.leak.free


def test_what_bench_toml_states_stands_above_the_calibration(tmp_path: Path) -> None:
    stated = load_bench(calibrated(tmp_path, '[light]\nleak = 0.1\ndead_time_kind = "non-paralyzable"\n'))
    assert stated.light.dead_time_kind == "non-paralyzable"
    light = LightModel.of(stated.light, with_mirrors(MIRRORS), Plan(frames=1))
    assert (light.leak.value, light.leak.source) == (0.1, "given")
    assert (light.edge_loss.value, light.edge_loss.source) == (0.02, "calibrated")


@pytest.mark.parametrize("kind", ["non-paralyzable", "paralyzable"])
def test_a_kind_that_is_not_certain_changes_nothing(kind: DeadTimeKind) -> None:
    assert LightModel.of(LightTable(dead_time_kind=kind)).leak.source == "assumed"
    below = MIRRORS.model_copy(update={"leak": Measured(value=-0.001, sigma=0.001)})
    assert LightModel.of(LightTable(), with_mirrors(below), Plan(frames=1)).leak.value == 0


def test_numbers_are_written_to_the_second_figure_of_their_error() -> None:
    assert str(Measured(value=585.4, sigma=24.2)) == "585 +- 24"
    assert str(Measured(value=0.0394997, sigma=0.00017)) == "0.03950 +- 0.00017"
    assert str(Measured(value=100811.0, sigma=141.9)) == "100,810 +- 140"
    assert str(Measured(value=3.0, sigma=0.0)) == "3 +- 0"
