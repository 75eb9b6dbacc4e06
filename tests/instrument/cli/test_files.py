"""The command and the files that it is given: whose they are, and what becomes of them."""

import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from instrument.cli.main import status
from instrument.session import Instrument
from instrument.storage import RecordingWriter
from protocols import CountBlock
from tests.support.benches import SMALL, bench_toml, plan_toml
from tests.support.plain_hdf5 import array

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="permissions and locks of POSIX")

PLAN = SMALL.model_copy(update={"frames": 400})


@pytest.fixture
def run(tmp_path: Path) -> Path:
    """A recording that can be analysed."""
    out = tmp_path / "data" / "run.h5"
    out.parent.mkdir()
    bench, plan = bench_toml(tmp_path), plan_toml(tmp_path, PLAN)
    assert status(["run", "--bench", str(bench), "--plan", str(plan), "--out", str(out)]) == 0
    return out


def test_a_read_only_recording_is_refused_before_the_work_and_analysed_into_another_file(
    tmp_path: Path, run: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    run.chmod(0o444)
    before = run.read_bytes()
    with monkeypatch.context() as patch:
        patch.setattr("instrument.analysis.analyse", pytest.fail)  # no work
        assert status(["analyse", str(run), "--no-pictures"]) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert "which is read-only" in said
    assert "--results FILE" in said
    results = tmp_path / "results.h5"
    assert status(["analyse", str(run), "--results", str(results)]) == 0
    assert run.read_bytes() == before
    assert array(results, "entry/analysis/image/image").shape == (64, 64)
    assert results.stat().st_mode & 0o777 == 0o444
    assert (tmp_path / "results-summary.png").exists()
    assert list(run.parent.iterdir()) == [run]


@pytest.mark.parametrize("role", ["recording", "background"])
def test_a_recording_that_is_being_written_is_refused_by_name_before_the_work(
    run: Path, capsys: pytest.CaptureFixture[str], role: str
) -> None:
    live = run.with_name("live.h5")
    with RecordingWriter(live, PLAN, picture_time_s=50e-6) as writer:
        writer.append(np.arange(2400.0))
        files = [live] if role == "recording" else [run, "--background", live]
        assert status(["analyse", *map(str, files), "--no-pictures"]) == 2
        writer.finish()
    said = " ".join(capsys.readouterr().err.split())
    assert f"live.h5, which is being recorded by process {os.getpid()} since 20" in said


def test_what_a_program_that_died_left_is_told(run: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    left = run.with_name(f".run.h5.analysed-4321-{'a' * 16}.part")
    left.write_bytes(b"half")
    assert status(["analyse", str(run), "--no-pictures"]) == 0
    assert "was left behind by a program that ended early" in " ".join(capsys.readouterr().err.split())
    assert not left.exists()
    left.with_name(f".new.h5.recorded-4321-{'a' * 16}.part").write_bytes(b"half")
    bench, plan = bench_toml(tmp_path), plan_toml(tmp_path)
    out = run.with_name("new.h5")
    assert status(["run", "--bench", str(bench), "--plan", str(plan), "--out", str(out)]) == 0
    assert "was left behind" in " ".join(capsys.readouterr().err.split())
    assert sorted(path.name for path in run.parent.iterdir()) == ["new.h5", "run.h5"]


def test_two_runs_on_one_path_give_one_recording_and_one_refusal(
    tmp_path: Path, run: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Both are told to overwrite; the second program starts before the first block of the first, and after it."""
    bench_file, plan = bench_toml(tmp_path), plan_toml(tmp_path, PLAN)
    command = [sys.executable, "-m", "kinopix", "run", "--overwrite", "--bench", str(bench_file), "--plan", str(plan)]
    ended: list[subprocess.CompletedProcess[str]] = []
    with Instrument.from_toml(bench_file) as bench:
        read = bench.counter.read

        def reading(timeout_s: float) -> CountBlock:
            if len(ended) < 2:
                ended.append(subprocess.run([*command, "--out", str(run)], capture_output=True, text=True, check=False))
            return read(timeout_s)

        monkeypatch.setattr(bench.counter, "read", reading)
        recording = bench.run(PLAN, run, overwrite=True)
    assert [second.returncode for second in ended] == [2, 2]
    for second in ended:
        assert f"being recorded by process {os.getpid()} since 20" in " ".join(second.stderr.split())
    np.testing.assert_array_equal(array(run, "entry/data/values"), recording.values)
    assert list(run.parent.iterdir()) == [run]
