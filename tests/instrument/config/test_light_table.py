"""The ``[light]`` table: read, refused, kept in the recording, and used."""

from pathlib import Path

import pytest

from instrument.config import ConfigError, LightTable, load_bench
from instrument.measurement import LightModel, Measurement, Parameter, first_light
from instrument.session import Instrument
from instrument.storage import open_recording
from tests.support.benches import SMALL, bench_toml


def _bench(folder: Path, *lines: str) -> Path:
    return bench_toml(folder, "\n".join(["[light]", *lines]) if lines else "")


def test_what_it_states_is_read() -> None:
    assert LightTable() == LightTable(leak=None, edge_loss=None, dead_time_kind="non-paralyzable")


def test_a_bench_without_the_table_knows_nothing(tmp_path: Path) -> None:
    assert load_bench(_bench(tmp_path)).light == LightTable()


@pytest.mark.parametrize("leak", [0, 0.04, 0.4])
@pytest.mark.parametrize("edge_loss", [0, 0.02, 1])
def test_numbers_within_bounds_are_taken(tmp_path: Path, leak: float, edge_loss: float) -> None:
    path = _bench(tmp_path, f"leak = {leak}", f"edge_loss = {edge_loss}", 'dead_time_kind = "paralyzable"')
    assert load_bench(path).light == LightTable(leak=leak, edge_loss=edge_loss, dead_time_kind="paralyzable")


@pytest.mark.parametrize(
    ("line", "message"),
    [
        ("leak = 0.41", "light.leak: saw 0.41; expected less than or equal to 0.4"),
        ("leak = -0.01", "light.leak: saw -0.01; expected greater than or equal to 0"),
        ("leak = nan", "light.leak: saw NaN; expected a finite number"),
        ("edge_loss = 1.1", "light.edge_loss: saw 1.1; expected less than or equal to 1"),
        ("edge_loss = -1", "light.edge_loss: saw -1; expected greater than or equal to 0"),
        ('edge_loss = "0.1"', 'light.edge_loss: saw "0.1"; expected a number'),
        (
            "edgeloss = 0.1",
            "light.edgeloss: saw an unknown key; expected one of leak, edge_loss, profile, dead_time_kind",
        ),
        ('dead_time_kind = "paralysable"', "did you mean 'paralyzable'?"),
    ],
)
def test_what_cannot_be_is_refused_with_its_line(tmp_path: Path, line: str, message: str) -> None:
    path = _bench(tmp_path, line)
    number = path.read_text().splitlines().index(line) + 1
    with pytest.raises(ConfigError) as caught:
        load_bench(path)
    assert f"bench.toml:{number}: light." in str(caught.value)
    assert message in str(caught.value)


def test_the_recording_knows_it_in_memory_and_in_the_file_and_the_measurement_uses_it(tmp_path: Path) -> None:
    path = _bench(tmp_path, "leak = 0.125", "edge_loss = 0.02")
    with Instrument.from_toml(path) as bench:
        recording = bench.run(SMALL, tmp_path / "run.h5")
    stated = LightTable(leak=0.125, edge_loss=0.02)
    assert recording.light == stated
    assert open_recording(tmp_path / "run.h5").light == stated
    for measured in (Measurement.of(recording), first_light(recording)):
        assert measured.light.leak == Parameter(value=0.125, source="given")
        assert measured.light.edge_loss == Parameter(value=0.02, source="given")
        assert measured.edge_loss_a_side == pytest.approx(0.02 / SMALL.superpixel)


def test_a_recording_of_a_bench_that_states_nothing_states_nothing(tmp_path: Path) -> None:
    with Instrument.from_toml(_bench(tmp_path)) as bench:
        bench.run(SMALL, tmp_path / "run.h5")
    read = open_recording(tmp_path / "run.h5")
    assert read.light == LightTable()
    assert Measurement.of(read).light == LightModel()
