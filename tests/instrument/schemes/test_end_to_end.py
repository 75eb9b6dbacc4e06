"""Every scheme from plan.toml to pictures: ``kinopix check``, ``run``, ``analyse``, on simulated devices and real drivers."""

import json
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from instrument.cli.main import status
from instrument.plan import MotionPlan, Plan
from instrument.recording import Recording
from instrument.session import Instrument
from instrument.storage import open_recording
from tests.support.benches import bench_toml
from tests.support.calibrations import calibrated_bench_toml, displacement
from tests.support.plain_hdf5 import array, text
from tests.support.plans import plan_of

BENCHES = Path(__file__).parents[3] / "examples" / "benches"
PATTERNS = {
    "fourier-hadamard": 6,
    "moment-hadamard": 4,
    "hadamard": 2,
    "fourier-3step": 6,
    "fourier-4step": 8,
    "moment": 3,
    "moment-complementary": 4,
}
PICTURES = {
    "fourier-hadamard": {"summary", "image", "trajectory", "error", "timing"},
    "moment-hadamard": {"summary", "image", "trajectory", "error", "timing"},
    "hadamard": {"summary", "image", "timing"},
    "fourier-3step": {"summary", "trajectory", "error", "timing"},
    "fourier-4step": {"summary", "trajectory", "error", "timing"},
    "moment": {"summary", "trajectory", "error", "timing"},
    "moment-complementary": {"summary", "trajectory", "error", "timing"},
}


def _plan_toml(folder: Path, scheme: str, *, moves: bool) -> Path:
    """500 frames of 32 x 32 px."""
    path = folder / "plan.toml"
    motion = "[motion]\nvelocity_mm_s = 25.0\nacceleration_mm_s2 = 50.0\n" if moves else ""
    path.write_text(f'scheme = "{scheme}"\nframes = 500\nimage_size = 32\nsuperpixel = 4\n{motion}')
    return path


def _recorded(folder: Path, scheme: str, *, moves: bool) -> Path:
    bench = bench_toml(folder, 'noise = { kind = "pixel", sigma = 0.03, seed = 1 }')
    plan = _plan_toml(folder, scheme, moves=moves)
    arguments = ["--bench", str(bench), "--plan", str(plan)]
    assert status(["check", *arguments]) == 0
    assert status(["run", *arguments, "--out", str(folder / "run.h5")]) == 0
    return folder / "run.h5"


REPEATS = {"fourier-4step", "moment", "moment-complementary"}
"""Schemes whose way is that of another one: what is theirs has tests of its own."""


@pytest.mark.parametrize(
    "scheme", [pytest.param(name, marks=[pytest.mark.thorough] * (name in REPEATS)) for name in PATTERNS]
)
def test_it_is_checked_run_reopened_analysed_and_drawn(
    tmp_path: Path, scheme: str, capsys: pytest.CaptureFixture[str]
) -> None:
    run = _recorded(tmp_path, scheme, moves=scheme != "hadamard")
    reopened = open_recording(run)
    assert reopened.plan == Plan.from_toml(tmp_path / "plan.toml")
    assert reopened.values.shape == (500, PATTERNS[scheme])
    assert reopened.timing is not None
    assert reopened.timing.verdict == "good"
    capsys.readouterr()

    assert status(["analyse", str(run), "--json"]) == 0

    figures = json.loads(capsys.readouterr().out)
    drawn = {Path(path).stem.removeprefix("run-") for path in figures["pictures"]}
    assert drawn == PICTURES[scheme]
    for path in figures["pictures"]:
        with Image.open(path) as picture:
            grey = np.asarray(picture.convert("L"))
        assert min(grey.shape) > 300
        assert grey.std() > 5, "an empty picture"
    assert json.loads(text(run, "/entry/analysis/table"))["frames"] == 500
    if scheme == "hadamard":
        assert figures["displacement_mse_px2"] is None
    else:
        assert figures["displacement_mse_px2"] < 0.05
        assert array(run, "/entry/analysis/track/displacement_px").shape == (500, 2)
    if "image" not in PICTURES[scheme]:
        assert figures["psnr_db"] is None
    else:
        assert figures["psnr_db"] > 25
        finer = figures["grid"]
        assert scheme != "hadamard" or finer == 1, "an object at rest shows nothing between the pixels"
        assert array(run, "/entry/analysis/image/image").shape == (finer * 32, finer * 32)
        x_px = array(run, "/entry/analysis/image/x_px")
        assert (x_px[0], x_px[-1]) == ((0.0, 31.0) if finer == 1 else (-0.25, 31.25))


def test_a_tracking_recording_is_analysed_whatever_image_method_is_asked_for(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    run = _recorded(tmp_path, "fourier-3step", moves=True)
    for tracking in ("joint", "smooth", "per-frame"):
        capsys.readouterr()
        assert status(["analyse", str(run), "--tracking", tracking, "--no-pictures"]) == 0
        assert "displacement MSE" in capsys.readouterr().out
    assert "PSNR" not in text(run, "/entry/analysis/table")


def test_a_moving_stage_with_a_scheme_that_sees_no_motion_is_warned_of(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    arguments = ["--bench", str(bench_toml(tmp_path)), "--plan", str(_plan_toml(tmp_path, "hadamard", moves=True))]
    assert status(["check", *arguments, "--json"]) == 0
    (row,) = [row for row in json.loads(capsys.readouterr().out)["checks"] if row["name"] == "displacement"]
    assert row["outcome"] == "warning"
    assert row["message"] == "hadamard sees no displacement, and the plan moves the stage"


def test_moments_have_no_limit_of_motion_a_frame(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    bench = calibrated_bench_toml(tmp_path, displacement(10.0, image_size=32, superpixel=4))
    said: dict[str, str] = {}
    for scheme in ("moment-hadamard", "fourier-3step"):
        plan = _plan_toml(tmp_path, scheme, moves=True)
        assert status(["check", "--bench", str(bench), "--plan", str(plan), "--json"]) == 0
        (row,) = [row for row in json.loads(capsys.readouterr().out)["checks"] if row["name"] == "displacement"]
        said[scheme] = row["message"]
    # 25 mm/s x 10 px/mm x 4 or 6 pictures of 50 us; 32 px over 2 periods and 2.
    assert said == {
        "moment-hadamard": "0.05 px a frame, unambiguous everywhere",
        "fourier-3step": "0.075 px a frame, unambiguous within 8 px",
    }


@pytest.mark.parametrize("scheme", ["moment-hadamard", "fourier-3step"])
def test_the_real_drivers_on_emulators_count_what_the_simulated_devices_count(tmp_path: Path, scheme: str) -> None:
    plan = plan_of(scheme, frames=300, superpixel=2).model_copy(
        update={"motion": MotionPlan(velocity_mm_s=25.0, acceleration_mm_s2=50.0)}
    )
    recordings: list[Recording] = []
    for bench in ("simulated", "mixed"):
        with Instrument.from_toml(BENCHES / f"{bench}.toml") as opened:
            recordings.append(opened.run(plan, tmp_path / f"{bench}.h5"))
    simulated, real = recordings
    assert real.timing is not None
    assert real.timing.verdict == "good"
    assert real.timing.bins_received == 300 * PATTERNS[scheme]
    np.testing.assert_array_equal(real.values, simulated.values)
    np.testing.assert_array_equal(open_recording(tmp_path / "mixed.h5").values, simulated.values)
