"""A series gives what each recording by itself gives, does nothing twice, and goes on after one that fails."""

import csv
import json
import os
import shutil
import signal
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from instrument.analysis import analyse_path
from instrument.cli.main import status
from instrument.series import COLUMNS, Request, analyse_series, recordings_in, write_table
from instrument.workers import Where
from protocols import InputError
from tests.instrument.series.same import assert_same_analysis
from tests.support.plain_hdf5 import array, opened, text

ROOT = Path(__file__).parents[3]
GOOD = ("later/fast.h5", "middle.h5", "slow.h5")


def test_folders_are_searched_to_their_depth_and_nothing_is_listed_twice(runs: Path) -> None:
    (runs / ".slow.h5.recorded-1-0000000000000000.part").write_bytes(b"")
    (runs / ".hidden").mkdir()
    (runs / ".hidden" / "x.h5").write_bytes(b"")
    (runs / "notes.txt").write_text("none")
    found = recordings_in([runs / "slow.h5", runs, str(runs / "later")])
    assert [str(path.relative_to(runs)) for path in found] == ["slow.h5", "later/fast.h5", "middle.h5", "none.h5"]
    (runs / "empty").mkdir()
    with pytest.raises(InputError, match="without a recording"):
        recordings_in([runs / "empty"])


def test_what_is_done_is_not_done_again_unless_settings_change_or_somebody_asks(runs: Path) -> None:
    recordings = [runs / "slow.h5", runs / "middle.h5"]
    request = Request(tracking="per-frame", method="dgi")
    assert analyse_series(recordings[:1], request).kept == frozenset()
    before = recordings[0].stat()

    series = analyse_series(recordings, request)
    assert series.kept == {recordings[0]}
    assert (recordings[0].stat().st_ino, recordings[0].stat().st_mtime_ns) == (before.st_ino, before.st_mtime_ns)
    assert set(series.found) == set(recordings)

    assert analyse_series(recordings, request.model_copy(update={"frames": 60})).kept == frozenset()
    assert analyse_series(recordings, request).kept == frozenset()
    assert analyse_series(recordings, request).kept == set(recordings)
    assert analyse_series(recordings, request, again=True).kept == frozenset()


def test_copies_leave_the_recordings_as_they_are_and_are_found_again(runs: Path, tmp_path: Path) -> None:
    results = tmp_path / "results"
    results.mkdir()
    recordings = [runs / name for name in GOOD]
    before = [path.read_bytes() for path in recordings]
    request = Request(tracking="per-frame", method="dgi", frames=60)
    assert not analyse_series(recordings, request, results=results).failures
    assert [path.read_bytes() for path in recordings] == before
    assert analyse_series(recordings, request, results=results).kept == set(recordings)
    other = analyse_series(recordings, Request(tracking="per-frame", method="dgi"), results=results)
    assert [failure.exit_code for failure in other.failures.values()] == [2, 2, 2]
    twice = [runs / "middle.h5", runs / "slow.h5", runs / "later" / "slow.h5"]
    for folder in ("results", "pictures"):
        with pytest.raises(InputError, match=r"several recordings with the name slow\.h5"):
            analyse_series(twice, **{folder: results})  # type: ignore[arg-type]


def test_a_copy_of_another_run_is_not_taken_for_that_of_this_one(runs: Path, tmp_path: Path) -> None:
    """Two runs with one name, each with a copy in the same folder of results: only the first is there."""
    request = Request(tracking="per-frame", method="dgi")
    assert not analyse_series([runs / "slow.h5"], request, results=tmp_path).failures
    (runs / "middle.h5").replace(runs / "later" / "slow.h5")
    other = analyse_series([runs / "later" / "slow.h5"], request, results=tmp_path)
    assert other.kept == frozenset()
    assert "which exists" in other.failures[runs / "later" / "slow.h5"].why


def test_a_background_and_a_number_of_frames_are_those_of_one_recording_by_itself(runs: Path) -> None:
    """Another run by the same plan, with a third of its light, serves as background."""
    with opened(runs / "middle.h5", "r+") as file:
        del file["/entry/checksum"]
        file["/entry/data/values"][:, :] *= 1 / 3
    shutil.copyfile(runs / "slow.h5", runs / "alone.h5")
    background = str(runs / "middle.h5")
    analyse_path(runs / "alone.h5", tracking="per-frame", method="dgi", frames=60, background=background)
    request = Request(tracking="per-frame", method="dgi", frames=60, background_file=background)
    series = analyse_series([runs / "slow.h5"], request)
    assert_same_analysis(runs / "slow.h5", runs / "alone.h5")
    (info,) = series.found.values()
    assert info.analysis is not None
    assert info.analysis.table["frames"] == 60
    assert info.analysis.settings["key"] == request.key
    assert request.key != request.model_copy(update={"background_file": str(runs / "later" / "fast.h5")}).key


def test_a_scratch_folder_changes_nothing_but_where_the_bytes_are_read(
    runs: Path, analysed_serially: Path, tmp_path: Path
) -> None:
    scratch, results = tmp_path / "scratch", tmp_path / "results"
    scratch.mkdir()
    results.mkdir()
    (runs / "slow.h5").chmod(0o640)
    assert not analyse_series([runs / "slow.h5"], scratch=scratch).failures
    assert_same_analysis(runs / "slow.h5", analysed_serially / "slow.h5")
    assert (runs / "slow.h5").stat().st_mode & 0o777 == 0o640

    assert not analyse_series([runs / "middle.h5"], scratch=scratch, results=results).failures
    assert_same_analysis(results / "middle.h5", analysed_serially / "middle.h5")
    assert list(scratch.iterdir()) == []
    assert "not there" in str(analyse_series([runs / "slow.h5"], again=True, scratch=tmp_path / "not there").failures)


@pytest.mark.skipif(sys.platform != "linux", reason="needs inotify")
def test_with_a_scratch_folder_the_recording_is_opened_once(runs: Path, tmp_path: Path) -> None:
    """By inotify: the copy is one pass over the file, and what else is asked of it reads none of its bytes."""
    import ctypes
    import struct

    libc = ctypes.CDLL(None)
    watch = libc.inotify_init1(os.O_NONBLOCK)
    accessed = 0x1

    def reads() -> int:
        try:
            events = os.read(watch, 1 << 20)
        except BlockingIOError:
            return 0
        return len(events) // struct.calcsize("iIII")

    path = runs / "slow.h5"
    libc.inotify_add_watch(watch, os.fsencode(path), accessed)
    assert path.read_bytes()
    one_pass = reads()
    assert one_pass >= 1
    job = analyse_series([path], Request(tracking="per-frame", method="dgi"), scratch=tmp_path, again=True)
    assert not job.failures
    assert reads() <= one_pass + 1
    os.close(watch)


SCRIPT = """
import sys
from instrument.series import analyse_series, recordings_in
from instrument.workers import Where

if __name__ == "__main__":
    analyse_series(
        recordings_in(sys.argv[1:]), where=Where(1), on_recording=lambda path, k, n: print(path, flush=True)
    )
"""


def test_after_a_kill_two_processes_do_the_rest_and_nothing_twice_and_name_what_fails(
    runs: Path, analysed_serially: Path, tmp_path: Path
) -> None:
    """All is as if each recording had been analysed by itself, to the bit."""
    script = tmp_path / "script.py"
    script.write_text(SCRIPT)
    with subprocess.Popen(
        [sys.executable, str(script), str(runs / "later"), str(runs)],
        env={**os.environ, "PYTHONPATH": str(ROOT)},
        stdout=subprocess.PIPE,
        text=True,
    ) as process:
        assert process.stdout is not None
        first = Path(process.stdout.readline().strip())
        process.send_signal(signal.SIGKILL)
        process.communicate(timeout=60)
    when = first.stat().st_mtime_ns
    heard: list[tuple[int, int]] = []

    series = analyse_series(
        recordings_in([runs]), where=Where(processes=2), on_recording=lambda _path, k, n: heard.append((k, n))
    )

    assert first in series.kept
    assert first.stat().st_mtime_ns == when
    assert heard == [(1, 4), (2, 4), (3, 4), (4, 4)]
    assert set(series.found) == {runs / name for name in GOOD}
    for name in GOOD:
        assert_same_analysis(runs / name, analysed_serially / name)
    assert [path.name for path in series.failures] == ["none.h5"]
    (failure,) = series.failures.values()
    assert "something else than an HDF5 file" in failure.why
    assert failure.exit_code == 2
    assert [path for path in runs.rglob("*") if path.name.endswith(".part")] == []


def test_the_table_has_a_row_for_each_with_units_in_its_names(runs: Path, tmp_path: Path) -> None:
    recordings = [runs / "none.h5", runs / "slow.h5"]
    with opened(runs / "slow.h5", "r+") as file:  # two counts that no counter gives: each a doubt
        del file["/entry/checksum"]
        file["/entry/data/values"][20, 1] = np.inf
        file["/entry/data/values"][40:, :] *= 2.0
    series = analyse_series(recordings, Request(tracking="smooth", method="dgi"))
    table = tmp_path / "table.csv"
    table.write_text("an older one")
    write_table(series, table)
    with table.open(newline="", encoding="utf-8") as file:
        failed, slow = csv.DictReader(file)
    assert list(slow) == list(COLUMNS)
    assert (failed["outcome"], slow["outcome"]) == ("failed", "analysed")
    assert "HDF5" in failed["why"]
    assert (slow["scheme"], slow["velocity_mm_s"], slow["frames"]) == ("fourier-hadamard", "10.0", "80")
    travel_x = array(runs / "slow.h5", "/entry/analysis/track/displacement_px")[-1, 0]
    assert float(slow["travel_x_px"]) == travel_x
    assert float(slow["speed_low_px_s"]) < float(slow["speed_px_s"]) < float(slow["speed_high_px_s"])
    assert slow["speed_mm_s"] == slow["turn_deg"] == ""
    doubts = json.loads(text(runs / "slow.h5", "/entry/analysis/table"))["doubts"]
    assert len(doubts) >= 2
    assert slow["doubts"] == " | ".join(doubts)
    assert [path.name for path in tmp_path.iterdir() if path.name.endswith(".part")] == []


def test_the_table_as_parquet_is_that_as_csv(runs: Path, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet", reason="pyarrow is not installed: no Parquet")
    series = analyse_series([runs / "slow.h5"], Request(tracking="smooth", method="dgi"))
    write_table(series, tmp_path / "table.parquet")
    write_table(series, tmp_path / "table.csv")
    (row,) = parquet.read_table(tmp_path / "table.parquet").to_pylist()
    with (tmp_path / "table.csv").open(newline="", encoding="utf-8") as file:
        (text,) = csv.DictReader(file)
    assert {name: "" if value is None else str(value) for name, value in row.items()} == text


@pytest.mark.parametrize(("name", "word"), [("table.xlsx", r"\.csv or \.parquet"), ("no/table.csv", "existing folder")])
def test_a_table_that_cannot_be_written_is_refused(runs: Path, tmp_path: Path, name: str, word: str) -> None:
    series = analyse_series([runs / "none.h5"])
    with pytest.raises(InputError, match=word):
        write_table(series, tmp_path / name)


def test_the_command_prints_one_table_and_tells_of_failures_by_its_exit_code(
    runs: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    options = ["--tracking", "smooth", "--method", "dgi", "--workers", "1"]
    table, pictures = tmp_path / "table.csv", tmp_path / "pictures"
    assert status(["analyse", str(runs / "later"), *options, "--pictures", str(pictures)]) == 0
    assert f"written {pictures}/fast-summary.png" in capsys.readouterr().out.replace("\n", "")
    assert (pictures / "fast-summary.png").is_file()
    one_by_itself = ["analyse", str(runs / "slow.h5"), "--tracking", "smooth", "--method", "dgi", "--no-pictures"]
    assert status(one_by_itself) == 0
    assert "Analysis of slow.h5" in capsys.readouterr().out
    assert status(["analyse", str(runs), *options, "--table", str(table)]) == 2
    told = capsys.readouterr()
    assert "1 of 4 recordings that could not be analysed" in told.err
    assert f"{runs}/none.h5: saw something else" in told.err.replace("\n", "")
    assert [line.split()[:2] for line in told.out.splitlines() if ".h5" in line] == [
        ["fast.h5", "kept"],
        ["middle.h5", "analysed"],
        ["none.h5", "failed"],
        ["slow.h5", "kept"],
    ]
    assert len(table.read_text().splitlines()) == 5

    assert status(["analyse", str(runs / "slow.h5"), str(runs / "middle.h5"), *options, "--json"]) == 0
    rows = json.loads(capsys.readouterr().out)["recordings"]
    assert [(Path(row["recording"]).name, row["outcome"]) for row in rows] == [
        ("slow.h5", "kept"),
        ("middle.h5", "kept"),
    ]
    assert status(["analyse", str(runs), "--table", "table.xlsx"]) == 2
    assert ".csv or .parquet" in capsys.readouterr().err
