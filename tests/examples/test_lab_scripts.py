"""The lab scripts, run as a user runs them, on simulated and on emulated benches."""

import csv
import runpy
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from instrument.config import CalibratedDevice, Calibration, DisplacementSection, write_calibration
from instrument.plan import MotionPlan
from instrument.session import Instrument
from instrument.storage import open_recording
from tests.support.benches import SMALL, bench_toml, plan_toml

EXAMPLES = Path(__file__).parents[2] / "examples"
EMULATED = EXAMPLES / "benches" / "alp-ni-mc600.toml"
QUICK = MotionPlan(velocity_mm_s=25.0, acceleration_mm_s2=200.0, settle_s=0.01)
PLAN = SMALL.model_copy(
    update={"frames": 120, "image_size": 32, "superpixel": 8, "pattern_rate_hz": 5000.0, "motion": QUICK}
)
SCENE = (
    "fresh_noise = true\n"
    'noise = { kind = "poisson", peak_counts = 150, dead_time_s = 2e-8, dark_rate_hz = 600, seed = 5 }'
)


def script(monkeypatch: pytest.MonkeyPatch, name: str, *arguments: object) -> None:
    path = EXAMPLES / f"{name}.py"
    monkeypatch.setattr("sys.argv", [str(path), *map(str, arguments)])
    runpy.run_path(str(path), run_name="__main__")


def emulated(folder: Path) -> Path:
    """The bench of the real drivers, with the scene of these tests."""
    text = EMULATED.read_text(encoding="utf-8")
    path = folder / "bench.toml"
    path.write_text(text[: text.index("[scene]")] + f"[scene]\n{SCENE}\n", encoding="utf-8")
    return path


def calibrated(bench: Path) -> Path:
    """The same bench, calibrated as its scene is."""
    with Instrument.from_toml(bench) as opened:
        devices = {role: CalibratedDevice.of(identity) for role, identity in opened.devices.identities().items()}
    along = 1.8 / 2**0.5  # 7.2 px/mm in 128 px, along the diagonal
    section = DisplacementSection(
        date=datetime.now(UTC),
        image_size=32,
        superpixel=8,
        px_per_mm_x=along,
        px_per_mm_y=along,
        covariance=((1e-6, 0.0), (0.0, 1e-6)),
    )
    write_calibration(bench.with_name("calibration.toml"), Calibration(bench=devices, displacement=section))
    bench.write_text('calibration = "calibration.toml"\n' + bench.read_text())
    return bench


@pytest.mark.parametrize("kind", ["simulated", pytest.param("emulated", marks=pytest.mark.thorough)])
def test_five_speeds_are_measured_as_they_were_commanded(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str, capsys: pytest.CaptureFixture[str]
) -> None:
    bench = calibrated(bench_toml(tmp_path, SCENE) if kind == "simulated" else emulated(tmp_path))
    script(monkeypatch, "five_speeds", bench, plan_toml(tmp_path, PLAN), tmp_path / "out")
    assert len(capsys.readouterr().out.splitlines()) == 5
    with (tmp_path / "out" / "speeds.csv").open() as file:
        rows = [[float(cell) for cell in row] for row in list(csv.reader(file))[1:]]
    assert [row[0] for row in rows] == pytest.approx([5, 10, 15, 20, 25])
    for commanded, measured, half_width in rows:
        assert measured == pytest.approx(commanded, abs=2 * half_width)
        assert 0 < half_width < 6
    with Image.open(tmp_path / "out" / "speeds.png") as picture:
        assert np.asarray(picture.convert("L")).std() > 10


def test_five_speeds_want_a_calibrated_bench(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(SystemExit, match="kinopix calibrate displacement"):
        script(monkeypatch, "five_speeds", bench_toml(tmp_path, SCENE), plan_toml(tmp_path, PLAN), tmp_path / "out")


@pytest.mark.parametrize("kind", [pytest.param("simulated", marks=pytest.mark.thorough), "emulated"])
def test_runs_are_repeated_until_the_image_is_good(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, kind: str, capsys: pytest.CaptureFixture[str]
) -> None:
    bench = bench_toml(tmp_path, SCENE) if kind == "simulated" else emulated(tmp_path)
    script(monkeypatch, "until_good", bench, plan_toml(tmp_path, PLAN), tmp_path / "out", 27)
    said = capsys.readouterr().out.splitlines()
    reached = [float(line.split(": ")[1].split()[0]) for line in said]
    assert reached[0] == -np.inf
    assert reached[-1] >= 27 > max(reached[:-1])
    assert len(list((tmp_path / "out").glob("run-*.h5"))) == len(said)
    assert np.load(tmp_path / "out" / "image.npy").shape == (32, 32)


def test_a_night_goes_on_after_a_bad_run_and_is_resumed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """The first run is good. Then a cable breaks: the second is tried twice and kept. In the morning the series is finished."""
    plan, out = plan_toml(tmp_path), tmp_path / "out"
    good = bench_toml(tmp_path, SCENE)
    script(monkeypatch, "overnight", good, plan, out, 1)
    first = (out / "run-000.h5").read_bytes()
    assert capsys.readouterr().out.splitlines()[-1] == "1 of 1 runs are good"
    good.write_text(good.read_text() + 'faults = [{ kind = "stall", picture = 100 }]\n')
    script(monkeypatch, "overnight", good, plan, out, 2)
    assert capsys.readouterr().out.splitlines()[-1] == "1 of 2 runs are good"
    with pytest.raises(SystemExit, match="3 runs in a row"):
        script(monkeypatch, "overnight", good, plan, out, 5)
    script(monkeypatch, "overnight", bench_toml(tmp_path, SCENE), plan, out, 4)
    assert capsys.readouterr().out.splitlines()[-1] == "4 of 4 runs are good"
    assert (out / "run-000.h5").read_bytes() == first
    assert all(open_recording(out / f"run-00{number}.h5").frame_valid.all() for number in range(4))
    assert len(list(out.glob("run-001-bad-*.h5"))) == 4
    with (out / "log.csv").open() as file:
        lines = list(csv.reader(file))
    assert [line[2] for line in lines if line[1] == "run-001.h5"] == [
        *("attempt 1 failed", "attempt 2 failed") * 2,
        "good",
    ]
    assert "sync" in lines[1][3]


def test_a_night_on_emulated_devices(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    script(monkeypatch, "overnight", emulated(tmp_path), plan_toml(tmp_path), tmp_path / "out", 2)
    assert len(list((tmp_path / "out").glob("run-???.h5"))) == 2


@pytest.mark.parametrize("name", ["five_speeds", "until_good", "overnight"])
def test_without_arguments_a_script_says_how_it_is_called(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(SystemExit, match=rf"python examples/{name}\.py bench\.toml plan\.toml"):
        script(monkeypatch, name)
