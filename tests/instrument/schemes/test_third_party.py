"""A scheme by a third party is found, checked, run, recorded and analysed; what is wrong with one is said."""

import json
from pathlib import Path

import numpy as np
import pytest

from instrument.cli.main import status
from instrument.config import ConfigError, PluginBroken, list_plugins
from instrument.joint import refine
from instrument.numerics import displacement_mse, psnr
from instrument.plan import MotionPlan, Plan
from instrument.reconstruction import reconstruct
from instrument.schemes import position_of, scheme_of
from instrument.storage import open_recording
from instrument.tracking import track
from protocols import Floats
from tests.support.benches import bench_toml, plan_toml
from tests.support.motions import letter_b
from tests.support.plans import plan_of
from tests.support.simulation import simulate

pytestmark = pytest.mark.usefixtures("zha")


def test_decoding_of_one_frame_by_hand() -> None:
    """S = 10, m = 8: 8 x 5 / 10 - 1/2 = 3.5 px and 8 x 2.5 / 10 - 1/2 = 1.5 px; falling, 8 (1 - 5 / 10) - 1/2 and so on."""
    values = np.array([[10.0, 5.0, 2.5, 6.0, 4.0]])
    for falling, expected in ((False, [3.5, 1.5]), (True, [3.5, 5.5])):
        scheme = scheme_of(plan_of("zha-moments", frames=1, image_size=8, falling=falling))
        np.testing.assert_allclose(position_of(scheme).signal(values, values @ scheme.light_weights), [expected])


def test_it_is_listed_with_the_others(capsys: pytest.CaptureFixture[str]) -> None:
    assert status(["drivers", "--json"]) == 0
    rows = {row["name"]: row for row in json.loads(capsys.readouterr().out)["plugins"] if row["kind"] == "scheme"}
    assert {"fourier-hadamard", "moment-hadamard", "hadamard", "fourier-3step"} <= set(rows)
    own = rows["zha-moments"]
    assert (own["distribution"], own["version"], own["ready"]) == ("kinopix-zha", "0.4.0", True)
    assert own["summary"] == "Moments of Zha 2021, with an image"
    assert rows["zha-loose"]["missing"] == "settings LooseSettings that ignore keys they do not know"


@pytest.mark.parametrize("falling", ["false", "true"])
def test_the_command_checks_runs_records_and_analyses_it(
    tmp_path: Path, falling: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """400 frames of 5 patterns on a simulated bench: 2,000 patterns."""
    bench = bench_toml(tmp_path, 'noise = { kind = "pixel", sigma = 0.02, seed = 1 }')
    plan = tmp_path / "plan.toml"
    plan.write_text(
        "frames = 400\nimage_size = 32\nsuperpixel = 4\n"
        f'[scheme]\nname = "zha-moments"\nfalling = {falling}\nupsampling = 4\n'
        "[motion]\nvelocity_mm_s = 25.0\nacceleration_mm_s2 = 50.0\n"
    )
    arguments = ["--bench", str(bench), "--plan", str(plan)]
    assert status(["check", *arguments]) == 0
    assert status(["run", *arguments, "--out", str(tmp_path / "run.h5"), "--live"]) == 0
    reopened = open_recording(tmp_path / "run.h5")
    assert reopened.plan == Plan.from_toml(plan)
    assert reopened.values.shape == (400, 5)
    capsys.readouterr()
    assert status(["analyse", str(tmp_path / "run.h5"), "--json"]) == 0
    figures = json.loads(capsys.readouterr().out)
    assert figures["displacement_mse_px2"] < 0.02
    assert figures["psnr_db"] > 25
    assert len(figures["pictures"]) == 5


def _diagonal(time_s: Floats) -> Floats:
    return 25 + 90 * np.stack([time_s, time_s], axis=1)


def test_fixed_patterns_that_measure_no_position_are_no_hindrance_to_joint_refinement() -> None:
    """The all-on pattern comes before the ramps."""
    recording = simulate(plan_of("zha-moments", frames=1000, upsampling=2), letter_b(), _diagonal, sigma=0.1, seed=1)
    assert recording.truth is not None
    tracked = track(recording)
    refined = refine(recording, tracked).trajectory
    before = displacement_mse(tracked.displacement_px, recording.truth.displacement_px)
    after = displacement_mse(refined.displacement_px, recording.truth.displacement_px)
    assert after < before / 2
    assert psnr(reconstruct(recording, refined).image, recording.truth.image) > 28


@pytest.mark.parametrize(
    ("name", "saw", "expected"),
    [
        ("zha-foreign", "kinopix_zha.wrong:foreign of type DriverPlugin", "a instrument.SchemePlugin"),
        ("zha-gone", "AttributeError: .*not_there", "to import without an error"),
        ("zha-loose", "settings LooseSettings that ignore keys they do not know", "settings that forbid them"),
        ("zha-nameless", "settings ZhaSettings whose name is 'zha-moments'", "'zha-nameless', as default"),
        ("zha-settings", "settings ForeignSettings that are no SchemeSettings", "a subclass of"),
        ("zha-uncounted", "settings UncountedSettings without patterns_per_frame", "the patterns in a frame"),
    ],
)
def test_what_cannot_be_a_plans_scheme_is_told_with_its_distribution(name: str, saw: str, expected: str) -> None:
    with pytest.raises(PluginBroken, match=saw) as caught:
        plan_of(name, frames=10)
    assert caught.value.device == f"scheme plug-in {name!r} of kinopix-zha 0.4.0"
    assert expected in caught.value.expected
    assert "repair or reinstall kinopix-zha 0.4.0" in caught.value.remedy
    line = next(line for line in list_plugins() if line.plugin.name == name)
    assert line.error == caught.value.saw


@pytest.mark.parametrize(
    ("name", "saw", "expected"),
    [
        ("zha-nothing", "an object of type tuple", "an instrument.schemes.Scheme"),
        ("zha-crash", "KeyError: 'no table for 128 px in zha-crash'", "to be made without an error"),
        ("zha-columns", "5 columns", "4, its settings' patterns_per_frame"),
        ("zha-weights", r"light_weights of shape \(4,\)", "(5,), one a column"),
    ],
)
def test_what_a_plug_in_makes_is_looked_at_before_it_is_used(name: str, saw: str, expected: str) -> None:
    with pytest.raises(PluginBroken, match=saw) as caught:
        scheme_of(plan_of(name, frames=10))
    assert caught.value.exit_code == 2
    assert caught.value.device == f"scheme plug-in {name!r} of kinopix-zha 0.4.0"
    assert caught.value.expected == expected


def test_a_broken_scheme_ends_the_command_with_2_before_anything_moves(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    for name, said in (
        ("zha-short", "a sequence of 50 pictures"),
        ("zha-columns", "5 columns"),
        ("zha-loose", "ignore keys"),
    ):
        plan = tmp_path / "plan.toml"
        plan.write_text(f'frames = 10\nimage_size = 32\nsuperpixel = 4\nscheme = "{name}"\n')
        out = tmp_path / "run.h5"
        assert status(["run", "--bench", str(bench_toml(tmp_path)), "--plan", str(plan), "--out", str(out)]) == 2
        assert said in " ".join(capsys.readouterr().err.split())
        assert not out.exists()


def test_mistakes_in_its_settings_are_told_with_line_and_suggestion(tmp_path: Path) -> None:
    plan = tmp_path / "plan.toml"
    plan.write_text('frames = 10\n[scheme]\nname = "zha-moments"\nfaling = true\nupsampling = 3\n')
    with pytest.raises(ConfigError) as caught:
        Plan.from_toml(plan)
    said = str(caught.value)
    assert "plan.toml:4: scheme.faling: saw an unknown key" in said
    assert "did you mean falling?" in said


def test_a_plan_of_it_can_be_written_and_read(tmp_path: Path) -> None:
    plan = plan_of("zha-moments", frames=7, falling=True).model_copy(update={"motion": MotionPlan(velocity_mm_s=5.0)})
    text = plan_toml(tmp_path, plan).read_text().replace("True", "true")
    (tmp_path / "plan.toml").write_text(text)
    assert Plan.from_toml(tmp_path / "plan.toml") == plan
    assert Plan.from_json(plan.model_dump_json()) == plan
