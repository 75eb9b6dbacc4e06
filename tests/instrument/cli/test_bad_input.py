"""Wrong input ends with one clear paragraph and exit code 2, a fault of the bench with 3. Never with a traceback."""

import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from instrument.cli.main import status
from instrument.session import Instrument
from instrument.storage import open_recording
from tests.support.benches import SMALL, bench_toml, plan_toml

Refused = Callable[..., str]


@pytest.fixture
def refused(capsys: pytest.CaptureFixture[str]) -> Refused:
    """Run the command, check its exit code and give what it said, on one line."""

    def run(*arguments: object, code: int = 2) -> str:
        assert status([str(argument) for argument in arguments]) == code
        said = capsys.readouterr()
        assert "Traceback" not in said.err
        return " ".join(said.err.split())

    return run


def test_every_mistake_of_a_plan_is_named_with_its_line_and_a_suggestion(tmp_path: Path, refused: Refused) -> None:
    plan = tmp_path / "plan.toml"
    plan.write_text('frames = "many"\nimage_sise = 128\n\n[motion]\nvelocity_um_s = 25000.0\n')
    said = refused("run", "--bench", bench_toml(tmp_path), "--plan", plan, "--out", tmp_path / "run.h5")
    assert "plan.toml:1" in said
    assert "plan.toml:2" in said
    assert "image_size" in said
    assert "plan.toml:5" in said
    assert "velocity_mm_s" in said
    assert not (tmp_path / "run.h5").exists()


def test_every_mistake_of_a_bench_is_named_at_once(tmp_path: Path, refused: Refused) -> None:
    bench = bench_toml(tmp_path, 'obejct = "letter-B"\nnoise = { kind = "pixle" }', counter="latency = 3")
    said = refused("check", "--bench", bench, "--plan", plan_toml(tmp_path))
    assert "obejct" in said
    assert "'object'" in said or "object" in said
    assert "pixel" in said
    assert "latency" in said


def test_a_missing_driver_is_named_with_those_that_are_installed(tmp_path: Path, refused: Refused) -> None:
    bench = bench_toml(tmp_path)
    bench.write_text(bench.read_text().replace('[counter]\ndriver = "simulated"', '[counter]\ndriver = "simulatd"'))
    said = refused("check", "--bench", bench, "--plan", plan_toml(tmp_path))
    assert "simulatd" in said
    assert "simulated" in said


def test_an_object_that_is_no_image_is_named(tmp_path: Path, refused: Refused) -> None:
    (tmp_path / "object.png").write_text("not an image")
    bench = bench_toml(tmp_path, 'object = "object.png"')
    assert "object.png" in refused("check", "--bench", bench, "--plan", plan_toml(tmp_path))


def test_an_object_file_that_is_missing_is_named(tmp_path: Path, refused: Refused) -> None:
    bench = bench_toml(tmp_path, 'object = "letter-Q"')
    said = refused("check", "--bench", bench, "--plan", plan_toml(tmp_path))
    assert "letter-Q" in said
    assert "letter-B" in said


@pytest.mark.parametrize(
    ("rows", "line"),
    [
        ("0,0,0\n0.1,1,1\n0.1,2,2\n", 4),  # time stands still
        ("0,0,0\n0.1,,1\n0.2,2,2\n", 3),  # an empty cell
        ("0,0,0\n0.1,nan,1\n0.2,2,2\n", 3),
        ("0,0,0\n0.01,0,0\n0.02,0,0\n0.03,0,0\n0.5,1,1\n", 6),  # a gap
    ],
)
def test_a_trajectory_with_gaps_in_time_is_refused_at_its_line(
    tmp_path: Path, refused: Refused, rows: str, line: int
) -> None:
    (tmp_path / "way.csv").write_text("t_s,x_px,y_px\n" + rows)
    bench = bench_toml(tmp_path, 'trajectory = "way.csv"')
    said = refused("check", "--bench", bench, "--plan", plan_toml(tmp_path))
    assert "way.csv" in said
    assert f"{line}" in said


def test_a_plan_that_the_modulator_cannot_play_is_refused_before_anything_moves(
    tmp_path: Path, refused: Refused
) -> None:
    plan = plan_toml(tmp_path, SMALL.model_copy(update={"pattern_rate_hz": 30_000.0}))
    said = refused("run", "--bench", bench_toml(tmp_path), "--plan", plan, "--out", tmp_path / "run.h5")
    assert "at least 44 us" in said
    assert not (tmp_path / "run.h5").exists()


def test_an_output_that_exists_is_kept(tmp_path: Path, refused: Refused) -> None:
    out = tmp_path / "run.h5"
    out.write_text("mine")
    said = refused("run", "--bench", bench_toml(tmp_path), "--plan", plan_toml(tmp_path), "--out", out)
    assert "--overwrite" in said
    assert out.read_text() == "mine"


def test_a_truncated_recording_is_named(tmp_path: Path, refused: Refused) -> None:
    out = tmp_path / "run.h5"
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        bench.run(SMALL, out)
    out.write_bytes(out.read_bytes()[:5000])
    said = refused("analyse", out)
    assert "run.h5" in said
    assert "truncated" in said


def test_a_file_that_is_no_recording_is_named(tmp_path: Path, refused: Refused) -> None:
    assert "no such file" in refused("analyse", tmp_path / "nothing.h5")
    (tmp_path / "text.h5").write_text("hello")
    assert "HDF5" in refused("analyse", tmp_path / "text.h5")


def test_a_stall_ends_with_3_and_names_the_partial_recording(tmp_path: Path, refused: Refused) -> None:
    bench = bench_toml(tmp_path, 'faults = [{ kind = "stall", picture = 100 }]')
    out = tmp_path / "run.h5"
    said = refused("run", "--bench", bench, "--plan", plan_toml(tmp_path), "--out", out, code=3)
    assert "100 of 240 patterns counted" in said
    assert "patterns are kept in" in said
    assert out.exists()


def test_a_sub_command_that_does_not_exist_ends_with_2(refused: Refused) -> None:
    assert "acquire" in refused("acquire")


def test_check_says_all_and_ends_with_2_where_something_stands_against_the_run(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plan = plan_toml(tmp_path, SMALL.model_copy(update={"pattern_rate_hz": 30_000.0}))
    assert status(["check", "--bench", str(bench_toml(tmp_path)), "--plan", str(plan)]) == 2
    cells = capsys.readouterr().out.replace("│", " ")  # a sentence may run over several lines of its cell
    assert "at least 44 us" in " ".join(cells.split())


def test_pictures_into_a_file_are_refused_before_the_work(tmp_path: Path, refused: Refused) -> None:
    out = tmp_path / "run.h5"
    assert (
        status(["run", "--bench", str(bench_toml(tmp_path)), "--plan", str(plan_toml(tmp_path)), "--out", str(out)])
        == 0
    )
    assert "which is no folder" in refused("analyse", out, "--pictures", out)
    assert "which is no folder" in refused("demo", "--out", out)


def test_a_run_that_cannot_be_trusted_ends_with_3_and_names_its_file(tmp_path: Path, refused: Refused) -> None:
    bench = bench_toml(tmp_path, 'faults = [{ kind = "double-edge", picture = 100 }]', counter="edge_times = false")
    out = tmp_path / "run.h5"
    said = refused("run", "--bench", bench, "--plan", plan_toml(tmp_path), "--out", out, code=3)
    assert "trusts no frame" in said
    assert "run.h5" in said
    assert out.exists()


@pytest.mark.parametrize(
    ("error", "told"),
    [
        (OSError(28, "No space left on device"), (3, "No space left on device")),
        (MemoryError("745 GiB"), (2, "lower frames or image_size")),
    ],
)
def test_what_the_machine_refuses_is_told_with_what_was_kept(
    tmp_path: Path, refused: Refused, monkeypatch: pytest.MonkeyPatch, error: Exception, told: tuple[int, str]
) -> None:
    def refuse(*_arguments: object, **_options: object) -> None:
        error.add_note("12 of 240 patterns are kept")
        raise error

    monkeypatch.setattr(Instrument, "start", refuse)
    arguments = ("--bench", bench_toml(tmp_path), "--plan", plan_toml(tmp_path), "--out", tmp_path / "run.h5")
    said = refused("run", *arguments, code=told[0])
    assert told[1] in said
    assert "12 of 240 patterns are kept" in said


@pytest.mark.parametrize(("name", "code"), [("SIGINT", 130), ("SIGTERM", 143), ("SIGHUP", 129)])
def test_a_run_that_is_ended_from_outside_makes_the_bench_safe_and_keeps_what_it_has(
    tmp_path: Path, name: str, code: int
) -> None:
    if sys.platform == "win32":
        pytest.skip("Windows ends a process without a word to it")
    slow = SMALL.model_copy(update={"frames": 1600, "pattern_rate_hz": 400.0, "motion": None})
    out = tmp_path / "run.h5"
    arguments = ["--bench", str(bench_toml(tmp_path, "realtime = true")), "--plan", str(plan_toml(tmp_path, slow))]
    watched = (
        "import os, signal, threading, pathlib\n"
        "signal.signal(signal.SIGINT, signal.default_int_handler)\n"
        "from instrument.cli.main import main\n"
        "from instrument import views\n"
        "class Bars(type(views.progress())):\n"
        "    def update(self, task, **what):\n"
        "        super().update(task, **what)\n"
        f"        if self.tasks[1].completed: os.kill(os.getpid(), signal.{name})\n"
        "views.progress = Bars\n"
        f"main({['run', *arguments, '--out', str(out)]!r})\n"
    )
    ended = subprocess.run([sys.executable, "-c", watched], capture_output=True, text=True, check=False)
    assert ended.returncode == code, ended.stderr
    assert "the bench is safe" in ended.stderr
    assert "patterns are kept in" in ended.stderr
    assert "Traceback" not in ended.stderr
    assert 0 < len(open_recording(out)) < 1600


@pytest.mark.parametrize(
    ("command", "option"),
    [
        (("count",), "--pattern-rate-hz"),
        (("calibrate", "detector"), "--pattern-rate-hz"),
        (("calibrate", "mirrors"), "--pattern-rate-hz"),
        (("calibrate", "mirrors"), "--seconds"),
        (("calibrate", "light"), "--pattern-rate-hz"),
        (("calibrate", "light"), "--seconds"),
        (("calibrate", "alignment"), "--pattern-rate-hz"),
        (("calibrate", "displacement"), "--pattern-rate-hz"),
    ],
)
@pytest.mark.parametrize("value", ["0", "-1", "nan", "inf"])
def test_what_is_no_time_and_no_rate_is_refused(
    tmp_path: Path, command: tuple[str, ...], option: str, value: str, refused: Refused
) -> None:
    said = refused(*command, "--bench", bench_toml(tmp_path), option, value)
    assert f"saw {option} {value}; expected a number above 0" in said


@pytest.mark.parametrize("name", ["both.txt", "nowhere/both.png"])
def test_a_comparison_that_cannot_be_drawn_is_refused_before_the_work(
    tmp_path: Path, name: str, refused: Refused
) -> None:
    still, run = tmp_path / "still.h5", tmp_path / "run.h5"
    for path in (still, run):
        with Instrument.from_toml(bench_toml(tmp_path)) as bench:
            bench.run(SMALL, path)
    said = refused("compare", still, run, "--picture", tmp_path / name)
    assert "ends in .png" in said
