"""The command as a user runs it, on simulated devices."""

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image
from serial.tools.list_ports_common import ListPortInfo

from instrument.cli.main import status
from instrument.plan import MotionPlan, Plan
from instrument.reconstruction import binned
from instrument.storage import open_recording
from tests.support.benches import SMALL, bench_toml, plan_toml
from tests.support.plain_hdf5 import array, text

MEDIUM = SMALL.model_copy(update={"frames": 400})
DEMO = SMALL.model_copy(update={"frames": 1666, "image_size": 128, "superpixel": 2})


@pytest.fixture(scope="module")
def demo(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder of one demo run."""
    folder = tmp_path_factory.mktemp("demo")
    assert status(["demo", "--out", str(folder)]) == 0
    return folder


def recorded(folder: Path, scene: str = "", plan: Plan = MEDIUM, name: str = "run.h5") -> Path:
    arguments = ["--bench", str(bench_toml(folder, scene)), "--plan", str(plan_toml(folder, plan))]
    assert status(["run", *arguments, "--out", str(folder / name)]) == 0
    return folder / name


def test_an_ideal_bench_beats_the_paper_on_the_paper_s_own_noise(tmp_path: Path) -> None:
    """The paper: 0.31 to 0.52 px^2 and 24.7 to 26.1 dB."""
    run = recorded(tmp_path, 'noise = { kind = "pixel", sigma = 0.1, seed = 1 }', DEMO)
    assert status(["analyse", str(run), "--no-pictures"]) == 0
    table = json.loads(text(run, "/entry/analysis/table"))
    found, truth = array(run, "/entry/analysis/track/displacement_px"), array(run, "/entry/truth/displacement_px")
    image, true_image = array(run, "/entry/analysis/image/image"), array(run, "/entry/truth/image")
    assert table["displacement_mse_px2"] == pytest.approx(np.mean((found - truth) ** 2))
    assert table["displacement_mse_px2"] < 0.02
    at_patterns = binned(image, 2)
    psnr_db = -10 * np.log10(np.mean((np.clip(at_patterns, 0, 1) - true_image) ** 2))
    assert table["psnr_db"] == pytest.approx(psnr_db, abs=1e-3)
    assert table["psnr_db"] > 33


def test_the_demo_beats_the_paper_on_a_bench_with_the_flaws_of_real_ones(demo: Path) -> None:
    """The mirrors leak (4 us / 2 + 8.5 us / 4) / 50 us = 0.0825 of the picture before; that and the rest is taken back."""
    table = json.loads(text(demo / "run.h5", "/entry/analysis/table"))
    assert json.loads(text(demo / "run.h5", "/entry/bench"))["scene"]["settings"]["realism"] == "realistic"
    assert table["displacement_mse_px2"] < 0.1
    assert table["psnr_db"] > 25
    assert table["light"]["leak"]["value"] == pytest.approx(0.0825, abs=3 * table["light"]["leak"]["sigma"])
    assert table["misfit"] == pytest.approx(1.0, abs=0.1)


def test_the_demo_draws_its_pictures(demo: Path) -> None:
    for name in ("summary", "image", "trajectory", "error", "timing"):
        with Image.open(demo / f"{name}.png") as picture:
            grey = np.asarray(picture.convert("L"))
        assert min(grey.shape) > 300
        assert grey.std() > 10, "an empty picture"


def test_the_demo_can_be_repeated_to_the_bit(demo: Path, tmp_path: Path) -> None:
    arguments = ["--bench", str(demo / "bench.toml"), "--plan", str(demo / "plan.toml")]
    assert status(["run", *arguments, "--out", str(tmp_path / "again.h5")]) == 0
    first, again = open_recording(demo / "run.h5"), open_recording(tmp_path / "again.h5")
    np.testing.assert_array_equal(first.values, again.values)


def test_the_demo_does_not_overwrite_unasked(demo: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert status(["demo", "--out", str(demo)]) == 2
    assert "--overwrite" in capsys.readouterr().err


def test_run_prints_the_timing_audit_as_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["--bench", str(bench_toml(tmp_path)), "--plan", str(plan_toml(tmp_path))]
    assert status(["run", *arguments, "--out", str(tmp_path / "run.h5"), "--json"]) == 0
    timing = json.loads(capsys.readouterr().out)["timing"]
    assert timing["verdict"] == "good"
    assert timing["patterns_recorded"] == 240


def test_run_shows_a_table_and_overwrites_when_asked(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    recorded(tmp_path, plan=SMALL)
    capsys.readouterr()
    arguments = ["--bench", str(bench_toml(tmp_path)), "--plan", str(plan_toml(tmp_path)), "--overwrite"]
    assert status(["run", *arguments, "--out", str(tmp_path / "run.h5")]) == 0
    assert "240 of 240, 240 bins" in capsys.readouterr().out


@pytest.mark.parametrize(("tracking", "highest_px2"), [("joint", 0.02), ("smooth", 0.1), ("per-frame", 0.5)])
def test_analyse_writes_into_the_recording_and_prints(
    tmp_path: Path, tracking: str, highest_px2: float, capsys: pytest.CaptureFixture[str]
) -> None:
    noisy = 'noise = { kind = "pixel", sigma = 0.05, seed = 1 }'
    run = recorded(tmp_path, noisy, plan=MEDIUM.model_copy(update={"image_size": 64}))
    capsys.readouterr()
    assert status(["analyse", str(run), "--tracking", tracking, "--no-pictures", "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert figures["frames"] == 400
    assert figures["displacement_mse_px2"] < highest_px2
    assert figures["pictures"] == []
    assert array(run, "/entry/analysis/track/displacement_px").shape == (400, 2)
    assert json.loads(text(run, "/entry/analysis/settings"))["tracking"] == tracking


def test_analyse_of_the_first_frames_leaves_the_others_open(tmp_path: Path) -> None:
    run = recorded(tmp_path)
    assert status(["analyse", str(run), "--frames", "200", "--method", "dgi"]) == 0
    found = array(run, "/entry/analysis/track/displacement_px")
    assert np.isfinite(found[:200]).all()
    assert np.isnan(found[200:]).all()
    assert (tmp_path / "run-summary.png").exists()


def test_a_background_is_taken_off(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A letter that stands still beside the object: without it in the values, the object is followed as before."""
    still = 'background = "letter-I"\nobject_height_px = 9'
    run = recorded(tmp_path, still)
    rest = MEDIUM.model_copy(update={"motion": None})
    background = recorded(tmp_path, f'object = "nothing"\n{still}', plan=rest, name="background.h5")
    capsys.readouterr()
    mse: list[float] = []
    for options in ([], ["--background", str(background)]):
        assert status(["analyse", str(run), "--tracking", "per-frame", "--no-pictures", "--json", *options]) == 0
        mse.append(json.loads(capsys.readouterr().out)["displacement_mse_px2"])
    assert mse[0] > 10 * mse[1]
    assert mse[1] < 0.05


def test_a_background_is_taken_off_photons_with_dead_time(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """As bright as the object, at a dead time that takes a tenth of the counts: found as light, it leaves no trace."""
    light = 'noise = { kind = "poisson", peak_counts = 300, dead_time_s = 2e-8, dark_rate_hz = 1e4, seed = 4 }'
    still = f'background = "letter-I"\nobject_height_px = 9\n{light}'
    run = recorded(tmp_path, still)
    rest = MEDIUM.model_copy(update={"motion": None})
    background = recorded(
        tmp_path, f"object_level = 0\n{still.replace('seed = 4', 'seed = 5')}", plan=rest, name="background.h5"
    )
    assert not array(background, "/entry/truth/image").any()
    capsys.readouterr()
    assert status(["analyse", str(run), "--no-pictures", "--json", "--background", str(background)]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert figures["displacement_mse_px2"] < 0.05
    assert figures["misfit"] == pytest.approx(1.0, abs=0.1)
    assert (
        figures["light_change"] < 4 * 900**0.5 / 300 / 40**0.5
    )  # noise of 900 counts in 300, mean of 40 frames, 4 sigma


def test_masked_frames_are_left_out_and_said(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run = recorded(tmp_path, 'faults = [{ kind = "drop-edge", picture = 1000 }]')
    capsys.readouterr()
    assert status(["analyse", str(run), "--no-pictures"]) == 0
    said = capsys.readouterr()
    assert "1 of 400 frames are masked" in " ".join(said.err.split())
    assert "400, 1 masked" in said.out


def test_a_recording_without_a_usable_frame_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = [
        *("--bench", str(bench_toml(tmp_path, 'faults = [{ kind = "stall", picture = 4 }]'))),
        *("--plan", str(plan_toml(tmp_path))),
    ]
    assert status(["run", *arguments, "--out", str(tmp_path / "run.h5")]) == 3
    capsys.readouterr()
    assert status(["analyse", str(tmp_path / "run.h5")]) == 2
    assert "none of them valid" in " ".join(capsys.readouterr().err.split())


def test_noise_without_an_object_is_refused(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    run = recorded(tmp_path, 'object = "nothing"\nnoise = { kind = "pixel", sigma = 0.1, seed = 1 }')
    capsys.readouterr()
    assert status(["analyse", str(run)]) == 2
    assert "no object in the light" in " ".join(capsys.readouterr().err.split())


def test_two_frames_give_a_result_without_a_stated_uncertainty(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = recorded(tmp_path)
    capsys.readouterr()
    assert status(["analyse", str(run), "--frames", "2", "--json", "--no-pictures"]) == 0
    assert json.loads(capsys.readouterr().out)["sigma_px"] is None
    assert status(["analyse", str(run), "--frames", "2"]) == 0


def test_an_object_that_leaves_the_field_is_doubted(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    motion = MotionPlan(velocity_mm_s=25.0, acceleration_mm_s2=50.0, field="may-leave")
    run = recorded(tmp_path, "px_per_mm = 12.0", plan=MEDIUM.model_copy(update={"motion": motion}))
    capsys.readouterr()
    assert status(["analyse", str(run), "--no-pictures"]) == 0
    assert "leaves the field" in " ".join(capsys.readouterr().err.split())


def test_drivers_are_listed_with_what_is_missing(capsys: pytest.CaptureFixture[str]) -> None:
    assert status(["drivers", "--json"]) == 0
    plugins = {(row["kind"], row["name"]): row for row in json.loads(capsys.readouterr().out)["plugins"]}
    assert plugins["modulator", "simulated"]["ready"]
    assert {("modulator", "dlp7000"), ("counter", "ni"), ("counter", "usb-ctr"), ("stage", "ka400z")} <= set(plugins)
    assert status(["drivers"]) == 0
    shown = capsys.readouterr().out
    assert "simulated" in shown
    assert max(shown.count(f"libalp{n}.so") for n in (41, 42, 43, 44, 50, 51)) <= 1, "each library is named once"
    assert "\n  To do: " in shown or all(row["ready"] for row in plugins.values())


def test_probe_looks_without_moving_anything(capsys: pytest.CaptureFixture[str]) -> None:
    assert status(["drivers", "probe"]) == 0
    for line in capsys.readouterr().out.splitlines():
        assert (
            line.startswith(("stage ka400z: ", "stage grbl: ", "stage zaber: ", "counter ", "modulator "))
            or line == "no device found; simulated ones need none"
        )


def test_probe_prints_a_line_for_each_device_that_a_driver_finds(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("serial.tools.list_ports.comports", lambda: [ListPortInfo("/dev/ttyTEST")])
    assert status(["drivers", "probe"]) == 0
    assert "stage ka400z: /dev/ttyTEST" in capsys.readouterr().out


def test_check_prints_every_answer_as_json(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    arguments = ["--bench", str(bench_toml(tmp_path)), "--plan", str(plan_toml(tmp_path))]
    assert status(["check", *arguments, "--json"]) == 0
    report = json.loads(capsys.readouterr().out)
    assert report["ok"]
    assert {"picture time", "memory", "stage", "displacement"} <= {row["name"] for row in report["checks"]}


@pytest.mark.parametrize("command", [[], ["run"], ["analyse"], ["check"], ["demo"], ["drivers"]])
def test_every_command_has_help(command: list[str], capsys: pytest.CaptureFixture[str]) -> None:
    assert status([*command, "--help"]) == 0
    assert "Usage" in capsys.readouterr().out


def test_the_version_is_printed(capsys: pytest.CaptureFixture[str]) -> None:
    assert status(["--version"]) == 0
    assert capsys.readouterr().out.startswith("kinopix 0.")
