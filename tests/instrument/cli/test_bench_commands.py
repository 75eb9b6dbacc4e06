"""Commands of one device, as a person at a new bench types them."""

import json
import math
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from instrument.cli.main import status
from instrument.session import Counting, Instrument
from sim_backends.bench import OpticalBench
from tests.instrument.cli.test_interrupts import assert_one_paragraph, ended
from tests.support.benches import bench_toml

BENCHES = Path(__file__).parents[3] / "examples" / "benches"
EMULATED = [BENCHES / "alp-ni-mc600.toml", BENCHES / "alp-usbctr-sc300.toml"]
SQUARE = 'object = "square"\nobject_height_px = 16\nstart_px = [16, 16]\n'
PHOTONS = SQUARE + 'noise = { kind = "poisson", peak_counts = 100, seed = 1 }'
SMALL = ("--image-size", "32", "--superpixel", "4")


def alone(folder: Path, role: str, scene: str = "") -> Path:
    """A bench.toml with one device."""
    path = folder / "bench.toml"
    path.write_text(f'[{role}]\ndriver = "simulated"\n[scene]\n{scene}\n')
    return path


@pytest.mark.parametrize("bench", EMULATED, ids=lambda path: path.stem)
def test_the_real_drivers_move_show_and_count(bench: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert status(["move", "12.5", "--bench", str(bench)]) == 0
    assert "stage: 12.5000 mm" in capsys.readouterr().out
    assert status(["show", "checker:4", "--bench", str(bench), "--seconds", "3"]) == 0
    assert "the modulator is dark" in capsys.readouterr().out
    assert status(["count", "--bench", str(bench), "--seconds", "0.05", "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert figures["pictures"] == 999
    rate_hz = 4e6 / (1 + 4e6 * 2e-8)  # 200 photons in 50 us, 20 ns dead after each
    assert figures["rate_hz"] == pytest.approx(rate_hz, abs=4 * figures["sigma_hz"])


@pytest.mark.parametrize("bench", [BENCHES / "simulated.toml", *EMULATED], ids=lambda path: path.stem)
def test_probe_tells_of_every_device(bench: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert status(["probe", "--bench", str(bench), "--json"]) == 0
    devices = json.loads(capsys.readouterr().out)["devices"]
    assert list(devices) == ["modulator", "counter", "stage"]
    assert all(device["ok"] for device in devices.values())
    assert devices["modulator"]["limits"]["columns"] == 1024
    assert devices["modulator"]["state"] == {"playing": "no"}
    assert devices["stage"]["state"]["position"] == "0.0000 mm"
    assert "no hardware stands behind it" in devices["counter"]["doubts"]


def test_probe_tells_of_the_others_where_one_does_not_open(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "bench.toml"
    path.write_text('[modulator]\ndriver = "dlp7000"\nlibrary = "none.so"\n[stage]\ndriver = "simulated"\n[scene]\n')
    assert status(["probe", "--bench", str(path)]) == 3
    said = capsys.readouterr()
    assert "simulated KA400Z" in said.out
    assert "none.so" in said.err


def test_commissioning_asks_before_anything_moves_and_writes_a_report(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """Without a terminal nobody can agree; with --yes somebody has. Neither loses an older report."""
    monkeypatch.chdir(tmp_path)
    command = ["probe", "--bench", str(BENCHES / "zaber.toml"), "--commission", "--only", "stage", "--out", "rack-3"]
    assert status(command) == 0
    assert "travel [not asked] nobody agreed to it" in (tmp_path / "rack-3.txt").read_text()
    assert status([*command, "--yes"]) == 2
    assert "rack-3.txt, which exists" in " ".join(capsys.readouterr().err.split())
    assert status([*command, "--yes", "--overwrite", "--json"]) == 0
    printed = json.loads(capsys.readouterr().out)
    assert printed == {**json.loads((tmp_path / "rack-3.json").read_text()), "warnings": []}
    assert printed["devices"][0]["measured"]["travel"]["state"] == "answered"


@pytest.mark.parametrize(
    ("options", "told"),
    [(["--yes"], "--yes without --commission"), (["--commission", "--only", "lamp"], "--only lamp")],
)
def test_options_of_a_commissioning_that_mean_nothing_are_refused(
    options: list[str], told: str, capsys: pytest.CaptureFixture[str]
) -> None:
    assert status(["probe", "--bench", str(BENCHES / "zaber.toml"), *options]) == 2
    assert told in capsys.readouterr().err


def test_a_commissioning_with_a_device_that_does_not_open_ends_with_3(tmp_path: Path) -> None:
    bench = tmp_path / "bench.toml"
    bench.write_text('[modulator]\ndriver = "dlp7000"\nlibrary = "none.so"\n')
    assert status(["probe", "--bench", str(bench), "--commission", "--yes", "--out", str(tmp_path / "a")]) == 3
    assert "none.so" in (tmp_path / "a.txt").read_text()


@pytest.mark.parametrize(
    ("target", "mm"), [("12.5", 12.5), ("+1.5", 21.5), ("+-1.5", 18.5), ("-2", None), ("500", None), ("where", 20.0)]
)
def test_the_stage_moves_to_or_by_and_is_refused_outside(
    tmp_path: Path, target: str, mm: float | None, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "bench.toml"
    path.write_text('[stage]\ndriver = "simulated"\nposition_mm = 20.0\n[scene]\n')
    assert status(["move", target, "--bench", str(path)]) == (2 if mm is None else 0)
    assert (f"stage: {mm:.4f} mm" if mm is not None else "") in capsys.readouterr().out


@pytest.mark.parametrize("target", ["far", "+", "nan", "+inf", ""])
def test_a_target_that_is_none_is_refused(tmp_path: Path, target: str, capsys: pytest.CaptureFixture[str]) -> None:
    assert status(["move", target, "--bench", str(alone(tmp_path, "stage"))]) == 2
    assert f"the target {target!r}" in " ".join(capsys.readouterr().err.split())


def test_a_stage_that_does_not_know_its_origin_is_said_and_can_be_homed(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "bench.toml"
    path.write_text('[stage]\ndriver = "simulated"\nposition_mm = 20.0\nhomed = false\n[scene]\n')
    assert status(["move", "where", "--bench", str(path)]) == 0
    assert "does not know its origin" in capsys.readouterr().err
    assert status(["move", "home", "--bench", str(path)]) == 0
    said = capsys.readouterr()
    assert "stage: 0.0000 mm" in said.out
    assert said.err == ""


def test_a_device_that_is_not_configured_is_told_by_name(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    stage = str(alone(tmp_path, "stage"))
    assert status(["show", "white", "--bench", stage]) == 2
    assert "modulator" in capsys.readouterr().err
    assert status(["count", "--bench", stage, "--seconds", "0.1"]) == 2
    said = capsys.readouterr().err
    assert "counter" in said
    assert "modulator" in said
    assert "stage" not in said.replace(stage, "")


def test_only_the_device_of_the_command_is_opened(tmp_path: Path) -> None:
    with Instrument.from_toml(bench_toml(tmp_path), only={"stage"}) as bench:
        assert list(bench.devices.by_role) == ["stage"]


def test_a_picture_is_held_again_after_its_order_has_ended(tmp_path: Path) -> None:
    """1,000 pictures of a second, then a dark one: at 1,500 s the order plays for the second time."""
    with Instrument.from_toml(alone(tmp_path, "modulator"), only={"modulator"}) as bench:
        bench.show("white", 1500.0)
        scene = bench.devices.scene
        assert isinstance(scene, OpticalBench)
        assert scene.clock.now_s() == pytest.approx(1500.0, abs=0.01)
        assert not bench.modulator.running
        assert scene.shown_until_s > 1500.0 - 0.2


def test_a_picture_from_a_file_fills_the_field(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    Image.fromarray(np.full((40, 80), 255, np.uint8)).save(tmp_path / "wide.png")
    bench = str(alone(tmp_path, "modulator"))
    assert status(["show", str(tmp_path / "wide.png"), "--bench", bench, "--seconds", "1", *SMALL]) == 0
    assert "128 x 128 of 1024 x 768 mirrors, for 1 s" in " ".join(capsys.readouterr().out.split())


@pytest.mark.parametrize("picture", ["wite", "checker:0:3", "columns:3", "columns:8-200", "gone.png", "bench.toml"])
def test_what_is_no_picture_is_refused(
    tmp_path: Path, picture: str, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    bench = str(alone(tmp_path, "modulator"))
    assert status(["show", picture, "--bench", bench, "--seconds", "1", *SMALL]) == 2
    assert picture in " ".join(capsys.readouterr().err.split())


@pytest.mark.parametrize("seconds", ["0", "-1", "nan"])
def test_a_time_that_is_none_is_refused(tmp_path: Path, seconds: str) -> None:
    assert status(["show", "white", "--bench", str(alone(tmp_path, "modulator")), "--seconds", seconds]) == 2
    assert status(["count", "--bench", str(bench_toml(tmp_path, PHOTONS)), "--seconds", seconds]) == 2


def test_count_draws_bar_and_histogram(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """100 counts in 50 us are 2 million a second, two fifths of the limit: 16 of 40 signs."""
    bench = str(bench_toml(tmp_path, PHOTONS, counter="max_count_rate_hz = 5e6"))
    assert status(["count", "--bench", bench, "--seconds", "0.1", *SMALL]) == 0
    said = capsys.readouterr().out
    assert "#" * 16 + "." in said
    assert "#" * 17 + "." not in said
    assert "1999, by their counts" in said


def test_dark_is_counted_with_a_black_picture(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bench = str(bench_toml(tmp_path, PHOTONS.replace("seed", "dark_rate_hz = 6e4, seed")))
    arguments = ["--bench", bench, "--seconds", "0.1", "--show", "black", "--json", *SMALL]
    assert status(["count", *arguments]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert figures["rate_hz"] == pytest.approx(6e4, abs=4 * math.sqrt(6e4 / 0.1))
    assert figures["sigma_hz"] == pytest.approx(math.sqrt(6e4 / 0.1), rel=0.1)


def test_the_figures_of_counts_follow_from_them() -> None:
    """Counts 8, 10, 12 in 1 ms: 10,000 +- sqrt(4 / 3) thousand a second, a variance of 4 over a mean of 10."""
    counting = Counting(np.array([8.0, 10.0, 12.0]), 1e-3, 4e4, 2e-5)
    assert counting.rate_hz == pytest.approx(1e4)
    assert counting.sigma_hz == pytest.approx(1e3 * math.sqrt(4 / 3))
    assert counting.light_hz == pytest.approx(1e4 / 0.8)
    assert counting.share_of_limit == pytest.approx(0.25)
    assert counting.variance_over_mean == pytest.approx(0.4)
    numbers, borders = counting.histogram()
    assert numbers.tolist() == [1, 0, 1, 0, 1]
    assert borders.tolist() == [7.5, 8.5, 9.5, 10.5, 11.5, 12.5]
    nothing = Counting(np.zeros(0), 1e-3, 4e4)
    assert math.isnan(nothing.rate_hz)
    assert math.isinf(nothing.sigma_hz)
    assert math.isnan(nothing.variance_over_mean)
    assert nothing.histogram()[0].sum() == 0


@pytest.mark.parametrize(
    ("name", "code", "command"),
    [("SIGINT", 130, ("move", "100")), ("SIGTERM", 143, ("show", "white")), ("SIGTERM", 143, ("count",))],
)
def test_a_signal_leaves_the_device_safe(tmp_path: Path, name: str, code: int, command: tuple[str, ...]) -> None:
    """It comes when the device is at work. The stage stands where it was stopped, and is asked twice."""
    bench = bench_toml(tmp_path, "realtime = true\n" + PHOTONS)
    where = {
        "move": "from sim_backends.devices.stage import SimulatedStage as s; at(s, 'position', ACT)",
        "show": "from instrument.session import holding; at(holding.Flag, 'wait', ACT)",
        "count": "from instrument.acquisition import run; at(run.Aligner, 'place', ACT)",
    }[command[0]]
    safe = "from instrument.session import instrument as i; before = i.make_safe\n"
    safe += "def made(devices):\n    before(devices); print('made safe:', *devices.by_role)\ni.make_safe = made\n"
    once = f"done = []\ndef act():\n    if not done:\n        done.append(1); send({name!r})\n"
    done = ended(once + safe + where.replace("ACT", "act"), *command, "--bench", bench)
    assert_one_paragraph(done, code)
    assert "the bench is safe" in done.stderr
    roles = {"move": "stage", "show": "modulator", "count": "modulator counter"}[command[0]]
    assert f"made safe: {roles}\n" in done.stdout
