"""``kinopix init`` writes files that load, and that say of every key what it is."""

import json
import re
from pathlib import Path

import pytest
from typer.testing import CliRunner

from instrument.cli.main import app
from instrument.config import ConfigError, load_bench
from instrument.plan import MotionPlan, Plan
from protocols import InputError

A_KEY_WITH_ITS_DEFAULT = re.compile(r"^# (\w+ = [^ #].*)$", re.MULTILINE)


def written(folder: Path, *arguments: str) -> str:
    result = CliRunner().invoke(app, ["init", str(folder), *arguments])
    if result.exception:
        raise result.exception
    return result.output


def test_the_files_load_as_they_are_and_with_every_default_written_out(tmp_path: Path) -> None:
    written(tmp_path)
    bench, plan = load_bench(tmp_path / "bench.toml"), Plan.from_toml(tmp_path / "plan.toml")
    assert plan == Plan(frames=1666, motion=MotionPlan(velocity_mm_s=25.0))
    for name, keys in (("bench.toml", 40), ("plan.toml", 9)):
        text = (tmp_path / name).read_text(encoding="utf-8")
        assert len(A_KEY_WITH_ITS_DEFAULT.findall(text)) >= keys
        (tmp_path / name).write_text(A_KEY_WITH_ITS_DEFAULT.sub(r"\1", text), encoding="utf-8")
    assert Plan.from_toml(tmp_path / "plan.toml") == plan
    again = load_bench(tmp_path / "bench.toml")
    assert json.loads(again.as_json()) == json.loads(bench.as_json())


def test_what_a_real_stage_needs_is_named_and_then_missed_by_the_check(tmp_path: Path) -> None:
    needed = ["travel_mm", "max_velocity_mm_s", "max_acceleration_mm_s2", "lead_mm", "microsteps", "home_velocity_mm_s"]
    assert f"bench.toml needs what only you can know: {', '.join(needed)}" in written(tmp_path, "--stage", "ka400z")
    with pytest.raises(ConfigError) as caught:
        load_bench(tmp_path / "bench.toml")
    assert [problem.key for problem in caught.value.problems] == [f"stage.{key}" for key in needed]


def test_the_whole_bench_is_asked_for_calibration_and_optics_and_no_name_of_a_class_is_shown(tmp_path: Path) -> None:
    written(tmp_path)
    text = (tmp_path / "bench.toml").read_text(encoding="utf-8")
    before_tables = text.split("[modulator]")[0]
    assert "# calibration =              # text" in before_tables
    assert '# magnification = ""' in before_tables
    assert "# leak =              # number >= 0, <= 0.4 or { value, sigma, source }" in text
    assert re.findall(r"\b[A-Z][a-z]+(?:[A-Z][a-z]+)+\b", text) == []


def test_the_schemas_lie_beside_the_files_and_are_named_by_them(tmp_path: Path) -> None:
    written(tmp_path / "new" / "folder", "--scheme", "hadamard")
    for name in ("bench", "plan"):
        first = (tmp_path / "new" / "folder" / f"{name}.toml").read_text(encoding="utf-8").splitlines()[0]
        assert first == f"#:schema ./{name}.schema.json"
        schema = json.loads((tmp_path / "new" / "folder" / f"{name}.schema.json").read_text(encoding="utf-8"))
        assert schema["title"] == f"{name}.toml of Kinopix"
    assert Plan.from_toml(tmp_path / "new" / "folder" / "plan.toml").scheme.name == "hadamard"


def test_files_that_are_there_are_left_alone(tmp_path: Path) -> None:
    (tmp_path / "plan.toml").write_text("frames = 1\n")
    with pytest.raises(InputError, match=r"plan\.toml in .* already"):
        written(tmp_path)
    assert [path.name for path in tmp_path.iterdir()] == ["plan.toml"]
    assert (tmp_path / "plan.toml").read_text() == "frames = 1\n"
    written(tmp_path, "--overwrite")
    assert Plan.from_toml(tmp_path / "plan.toml").frames == 1666


@pytest.mark.parametrize(
    ("option", "name", "known"), [("--stage", "ka40", "ka400z, simulated"), ("--scheme", "fourier", "fourier-3step")]
)
def test_a_driver_or_scheme_that_is_not_there_is_named_with_those_that_are(
    tmp_path: Path, option: str, name: str, known: str
) -> None:
    with pytest.raises(InputError, match=repr(name)) as caught:
        written(tmp_path, option, name)
    assert known in caught.value.expected
    assert list(tmp_path.iterdir()) == []
