"""Many moving runs make one calibration: each measured once, whoever does it, and nothing lost by an interrupt."""

import csv
import json
import shutil
from datetime import UTC, datetime
from pathlib import Path

import pytest

from instrument import Instrument, MotionPlan, Plan
from instrument.calibration import displacement_of_run, displacement_of_runs, pooled
from instrument.cli.main import status
from instrument.config import DisplacementSection, read_calibration
from instrument.storage import open_recording
from instrument.workers import Where
from tests.support.benches import bench_toml
from tests.support.calibrations import MEASURED_SCENE

DATE = datetime(2026, 1, 2, tzinfo=UTC)


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Three runs, a copy of one, and a file that is no recording; beside the bench.toml of their bench."""
    folder = tmp_path_factory.mktemp("runs")
    (folder / "runs").mkdir()
    with Instrument.from_toml(bench_toml(folder, MEASURED_SCENE)) as bench:
        for name, speed in (("a", 25.0), ("b", 30.0), ("c", 35.0)):
            motion = MotionPlan(start_mm=1.0, velocity_mm_s=speed)
            bench.run(Plan(frames=300, image_size=32, superpixel=4, motion=motion), folder / "runs" / f"{name}.h5")
    shutil.copyfile(folder / "runs" / "a.h5", folder / "runs" / "copy.h5")
    (folder / "runs" / "none.h5").write_bytes(b"no recording")
    return folder


@pytest.fixture(scope="module")
def serially(recorded: Path) -> dict[str, DisplacementSection]:
    return {name: displacement_of_run(open_recording(recorded / "runs" / f"{name}.h5")) for name in "abc"}


def without_date(section: DisplacementSection) -> DisplacementSection:
    """A section, but for when it was made."""
    return section.model_copy(update={"date": DATE})


@pytest.mark.parametrize("processes", [1, pytest.param(2, marks=pytest.mark.thorough)])
def test_after_an_interrupt_the_rest_is_done_and_nothing_twice(
    recorded: Path, serially: dict[str, DisplacementSection], tmp_path: Path, processes: int
) -> None:
    """All is as if each run had been measured by itself, to the bit."""
    runs = [recorded / "runs" / f"{name}.h5" for name in ("a", "copy", "none", "b", "c")]
    points = tmp_path / "points"

    def interrupt(path: Path, done: int, total: int) -> None:
        assert (path, done, total) == (runs[0], 1, 4)
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        displacement_of_runs(runs, points, on_run=interrupt)
    (first,) = points.iterdir()
    when = first.stat().st_mtime_ns
    heard: list[tuple[int, int]] = []

    done = displacement_of_runs(runs, points, where=Where(processes), on_run=lambda _path, k, n: heard.append((k, n)))

    assert done.kept == {runs[0]}
    assert first.stat().st_mtime_ns == when
    assert heard == [(1, 4), (2, 4), (3, 4), (4, 4)]
    for path in (runs[0], *runs[3:]):
        assert without_date(done.found[path]) == without_date(serially[path.stem])
    assert set(done.failures) == {runs[1], runs[2]}
    assert done.failures[runs[1]].why == f"the same run as {runs[0]}, which counts once"
    assert "something else than an HDF5 file" in done.failures[runs[2]].why
    assert {failure.exit_code for failure in done.failures.values()} == {2}
    assert len(list(points.iterdir())) == 3

    (damaged,) = sorted(points.iterdir())[:1]
    damaged.write_text("{")
    assert len(displacement_of_runs(runs, points).kept) == 2
    assert displacement_of_runs(runs[:1], points, again=True).kept == frozenset()


def test_the_command_writes_the_mean_and_a_table_and_names_what_fails(
    recorded: Path, serially: dict[str, DisplacementSection], tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out, table = tmp_path / "found.toml", tmp_path / "table.csv"
    arguments = ["calibrate", "displacement", "--bench", str(recorded / "bench.toml"), "--out", str(out)]
    runs = str(recorded / "runs")
    assert status([*arguments, "--from", runs, "--workers", "1", "--table", str(table)]) == 2
    told = capsys.readouterr()
    assert "2 of 5 recordings that could not be measured" in told.err
    assert f"{runs}/none.h5: saw something else" in told.err.replace("\n", "")
    assert "px/mm" in told.out
    found = read_calibration(out).displacement
    assert found is not None
    assert without_date(found) == without_date(pooled({name: serially[name] for name in "abc"}))
    assert abs(found.px_per_mm - 2.0) < 5 * found.px_per_mm_sigma
    with table.open(newline="", encoding="utf-8") as file:
        rows = list(csv.DictReader(file))
    outcomes = [(Path(row["recording"]).stem, row["outcome"]) for row in rows]
    assert outcomes == [("a", "measured"), ("b", "measured"), ("c", "measured"), ("copy", "failed"), ("none", "failed")]
    assert float(rows[1]["px_per_mm"]) == serially["b"].px_per_mm
    assert float(rows[1]["axis_angle_sigma_deg"]) == serially["b"].axis_angle_sigma_deg
    assert rows[3]["why"].startswith("the same run as")

    assert status([*arguments, "--from", f"{runs}/b.h5", "--from", f"{runs}/c.h5", "--json"]) == 0
    told = capsys.readouterr()
    assert sorted(line.split()[:2] for line in told.err.splitlines() if ".h5" in line) == [
        ["b.h5", "kept"],
        ["c.h5", "kept"],
    ]
    two = pooled({name: serially[name] for name in "bc"})
    assert json.loads(told.out)["px_per_mm"] == two.px_per_mm


def test_what_cannot_be_asked_of_many_runs_is_said_before_the_work(
    recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    out = tmp_path / "found.toml"
    arguments = ["calibrate", "displacement", "--bench", str(recorded / "bench.toml"), "--out", str(out)]
    assert status([*arguments, "--span-mm", "1", "5", "--workers", "2"]) == 2
    assert "without --from" in capsys.readouterr().err
    assert status([*arguments, "--from", str(recorded / "runs"), "--table", "table.xlsx"]) == 2
    assert ".csv or .parquet" in capsys.readouterr().err
    none = str(recorded / "runs" / "none.h5")
    assert status([*arguments, "--from", none, "--from", str(tmp_path / "nothing.h5"), "--workers", "1"]) == 2
    assert "2 of 2 recordings that could not be measured" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []
