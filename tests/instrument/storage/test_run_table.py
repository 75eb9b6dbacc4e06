"""``[run]``: from the plan or the command into the recording, and from there to whoever looks at it."""

import json
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from instrument.cli.main import status
from instrument.config import ConfigError, RunTable
from instrument.plan import Plan
from instrument.recording import Recording
from instrument.schemes import scheme_of
from instrument.storage import RecordingWriter, open_recording, recording_info
from instrument.views import about_in_words
from tests.support import plain_hdf5 as plain
from tests.support.benches import bench_toml

ABOUT = RunTable(title="first light", user="A. Reader", sample="chrome B", notes="filter OD 1\nlamp 2 h on")
PLAN = Plan(frames=4, image_size=8, run=ABOUT)


def written(path: Path, plan: Plan) -> Path:
    with RecordingWriter(path, plan, picture_time_s=50e-6) as writer:
        writer.append(np.arange(24.0), np.arange(24.0) * 50e-6)
        writer.finish()
    return path


def test_a_recording_has_it_where_nexus_has_it(tmp_path: Path) -> None:
    """NXentry/title, NXuser/name, NXsample/name, NXnote/data and type: the base classes of the NeXus manual."""
    path = written(tmp_path / "run.h5", PLAN)
    found = {name: plain.text(path, f"entry/{name}") for name in ("title", "user/name", "sample/name", "notes/data")}
    assert found == {
        "title": "first light",
        "user/name": "A. Reader",
        "sample/name": "chrome B",
        "notes/data": "filter OD 1\nlamp 2 h on",
    }
    assert plain.text(path, "entry/notes/type") == "text/plain"
    classes = {group: plain.attribute(path, f"entry/{group}", "NX_class") for group in ("user", "sample", "notes")}
    assert classes == {"user": "NXuser", "sample": "NXsample", "notes": "NXnote"}
    info = recording_info(path)
    assert (info.title, info.user, info.sample, info.notes) == tuple(found.values())
    assert open_recording(path).plan.run == ABOUT


def test_what_nobody_said_is_not_there(tmp_path: Path) -> None:
    """A plan without the table is stored as programs before it know plans, and a title alone makes no empty groups."""
    assert {"run", "stop_if"}.isdisjoint(json.loads(Plan(frames=4).model_dump_json()))
    path = written(tmp_path / "run.h5", Plan(frames=4, image_size=8))
    assert (recording_info(path).title, recording_info(path).user) == ("run", "")
    titled = written(tmp_path / "titled.h5", Plan(frames=4, image_size=8, run=RunTable(title="x")))
    with plain.opened(titled) as file:
        assert {"user", "sample", "notes"}.isdisjoint(file["entry"])


_TEXT = st.text(st.characters(blacklist_categories=("Cc", "Cs")), max_size=40)


@settings(deadline=None)
@given(st.builds(RunTable, title=_TEXT, user=_TEXT, sample=_TEXT, notes=_TEXT))
def test_any_text_comes_back_from_the_plan(table: RunTable) -> None:
    plan = Plan(frames=4, image_size=8, run=table)
    assert (plan.run is None) == (table == RunTable())
    assert Plan.from_json(plan.model_dump_json()) == plan


@pytest.mark.parametrize("text", ["two\nlines", "\x1b[2J", "\x00", "x" * 201])
def test_what_is_no_line_of_text_is_refused(text: str) -> None:
    with pytest.raises(ValidationError):
        RunTable(title=text)


def test_it_changes_nothing_of_the_patterns() -> None:
    """The same scheme serves both, and a recording with another title is a background all the same."""
    other = PLAN.model_copy(update={"run": RunTable(title="background")})
    assert scheme_of(PLAN) is scheme_of(other)
    run, background = (Recording(plan, np.ones((4, 6)), np.ones(4, bool), 50e-6) for plan in (PLAN, other))
    assert run.minus(background).background is not None


def test_a_plan_says_it_in_one_line() -> None:
    assert about_in_words(PLAN) == "first light, sample chrome B, by A. Reader"
    assert about_in_words(PLAN.model_copy(update={"run": RunTable(user="A. Reader")})) == "by A. Reader"
    assert about_in_words(Plan(frames=1)) == ""


def test_a_mistake_in_the_table_is_named_with_its_line(tmp_path: Path) -> None:
    (tmp_path / "plan.toml").write_text('frames = 4\n[run]\nsampel = "B"\n')
    with pytest.raises(ConfigError, match=r"plan\.toml:3: run\.sampel.*did you mean sample\?"):
        Plan.from_toml(tmp_path / "plan.toml")


def test_an_option_stands_above_the_plan_and_info_shows_it(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    plan = tmp_path / "plan.toml"
    plan.write_text('frames = 40\nimage_size = 32\nsuperpixel = 4\n[run]\ntitle = "old"\nuser = "A. Reader"\n')
    out = tmp_path / "run.h5"
    asked = ["run", "--bench", str(bench_toml(tmp_path)), "--plan", str(plan), "--out", str(out), "--log"]
    assert status([*asked, "--title", "a\tb"]) == 2
    assert "--title 'a\\tb'" in capsys.readouterr().err
    assert not out.exists()
    assert status([*asked, "--title", "new", "--sample", "chrome B"]) == 0
    assert recording_info(out).title == "new"
    assert open_recording(out).plan.run == RunTable(title="new", user="A. Reader", sample="chrome B")
    log = out.with_suffix(".log").read_text()
    assert "run: counting" in log
    assert log.count("ended with exit code 0") == 1
    odd = tmp_path / "odd.log"
    assert status(["--verbose", *asked[:6], str(odd), "--log"]) == 0
    assert len(open_recording(odd)) == 40
    assert "DEBUG kinopix: run: patterns 0 to" in (tmp_path / "odd.log.log").read_text()
    capsys.readouterr()
    assert status(["info", str(out)]) == 0
    said = " ".join(capsys.readouterr().out.replace("│", " ").split())
    assert "title new user A. Reader sample chrome B" in said
