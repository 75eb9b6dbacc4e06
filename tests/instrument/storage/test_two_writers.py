"""One writer a recording: whoever comes second is refused by name, and an older recording stays until it is replaced."""

import os
import subprocess
import sys
from collections.abc import Callable, Generator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager, suppress
from pathlib import Path
from threading import Barrier, BrokenBarrierError

import numpy as np
import pytest

from instrument.plan import Plan
from instrument.storage import (
    RecordingWriter,
    in_use,
    open_recording,
    refuse_existing,
    refuse_unchangeable,
    refuse_while_written,
    remains_of,
    write_analysis,
)
from protocols import CountBlock, InputError

PLAN = Plan(frames=8, image_size=8)
OLD = np.arange(48, dtype=np.float64)
NEW = 1000 - OLD

posix = pytest.mark.skipif(sys.platform == "win32", reason="locks of POSIX")


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """Where nothing is yet."""
    return tmp_path / "run.h5"


def write(path: Path, values: np.ndarray[tuple[int], np.dtype[np.float64]], *, overwrite: bool = False) -> None:
    with RecordingWriter(path, PLAN, picture_time_s=50e-6, overwrite=overwrite) as writer:
        writer.append(values)
        writer.finish()


def test_a_new_recording_takes_its_place_with_the_first_block(path: Path) -> None:
    with RecordingWriter(path, PLAN, picture_time_s=50e-6) as writer:
        assert not path.exists()
        writer.append_raw(CountBlock(first_bin=0, counts=OLD[:6].astype(np.uint32)))
        assert list(path.parent.iterdir()) == [path]
        writer.append(OLD[:6])
        writer.finish()
    np.testing.assert_array_equal(open_recording(path).values.ravel(), OLD[:6])


def test_the_old_recording_stays_until_the_new_one_has_a_block(path: Path) -> None:
    """And whoever reads the old one keeps it."""
    write(path, OLD)
    before = path.read_bytes()
    with RecordingWriter(path, PLAN, picture_time_s=50e-6, overwrite=True) as writer:
        assert path.read_bytes() == before
        with path.open("rb") as reader:
            writer.append(NEW)
            assert reader.read() == before
        np.testing.assert_array_equal(open_recording(path).values.ravel(), NEW)
        writer.finish()
    np.testing.assert_array_equal(open_recording(path).values.ravel(), NEW)


def test_a_run_that_fails_before_its_first_block_leaves_the_old_recording_alone(path: Path) -> None:
    write(path, OLD)
    before, then = path.read_bytes(), path.stat()

    def fail() -> None:
        with RecordingWriter(path, PLAN, picture_time_s=50e-6, overwrite=True):
            raise RuntimeError("the counter does not arm")

    with pytest.raises(RuntimeError, match="arm"):
        fail()
    assert path.read_bytes() == before
    assert path.stat() == then
    assert list(path.parent.iterdir()) == [path]


@posix
@pytest.mark.parametrize("overwrite", [False, True])
@pytest.mark.parametrize("begun", [False, True])
def test_the_second_run_is_refused_by_name(path: Path, *, overwrite: bool, begun: bool) -> None:
    if overwrite:
        write(path, OLD)
    with RecordingWriter(path, PLAN, picture_time_s=50e-6, overwrite=overwrite) as writer:
        if begun:
            writer.append(NEW[:6])
        said = rf"run\.h5, which is being recorded by process {os.getpid()} since 20\d\d-\d\d-\d\dT"
        for question in (
            lambda: refuse_existing(path, overwrite=True),
            lambda: RecordingWriter(path, PLAN, picture_time_s=50e-6, overwrite=True),
            lambda: refuse_while_written(path),
            lambda: refuse_unchangeable(path),
            lambda: write_analysis(path, displacement_px=np.ones((8, 2)), image=None),
        ):
            with pytest.raises(InputError, match=said):
                question()
        writer.append(NEW[6:] if begun else NEW)
        writer.finish()
    np.testing.assert_array_equal(open_recording(path).values.ravel(), NEW)
    assert list(path.parent.iterdir()) == [path]


@posix
def test_of_two_runs_that_begin_at_the_same_moment_one_records(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each looks for the other once it has a file of its own: if both had one by then, both would be refused."""
    both_are_there, both_have_a_file = Barrier(2), Barrier(2)
    look = in_use.refuse_while_made

    def meet(_path: Path, _numbers: int) -> None:
        both_are_there.wait(10)

    def look_late(path: Path, *, but: Path) -> None:
        try:
            with suppress(BrokenBarrierError):
                both_have_a_file.wait(0.5)
            look(path, but=but)
        finally:
            with suppress(BrokenBarrierError):
                both_have_a_file.wait(0.5)

    monkeypatch.setattr("instrument.storage.writer.refuse_full_disk", meet)
    monkeypatch.setattr("instrument.storage.placed_file.refuse_while_made", look_late)

    def begin(_which: int) -> RecordingWriter | InputError:
        try:
            return RecordingWriter(path, PLAN, picture_time_s=50e-6)
        except InputError as error:
            return error

    with ThreadPoolExecutor(2) as pool:
        begun = sorted(pool.map(begin, range(2)), key=lambda one: isinstance(one, InputError))
    assert isinstance(begun[0], RecordingWriter)
    with begun[0] as writer:
        writer.append(NEW)
        writer.finish()
    assert isinstance(begun[1], InputError)
    assert f"being recorded by process {os.getpid()}" in begun[1].saw


@posix
def test_a_run_is_refused_while_the_old_recording_is_analysed(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    write(path, OLD)
    asked: list[str] = []

    def ask(_file: int) -> None:
        with pytest.raises(InputError) as caught:
            refuse_existing(path, overwrite=True)
        asked.append(caught.value.saw)

    monkeypatch.setattr("instrument.storage.edit.os.fsync", ask)
    write_analysis(path, displacement_px=np.ones((8, 2)), image=None)
    assert f"being analysed by process {os.getpid()} since 20" in asked[0]


def test_a_name_that_is_taken_meanwhile_is_left_alone_and_the_counts_are_kept_beside(path: Path) -> None:
    with RecordingWriter(path, PLAN, picture_time_s=50e-6) as writer:
        path.write_text("mine")
        writer.append_raw(CountBlock(first_bin=0, counts=OLD.astype(np.uint32)))
        writer.append(OLD)
        writer.finish()
    assert "run.h5, which another program has made since the run began" in str(writer.name_taken)
    assert str(writer.path) in str(writer.name_taken)
    assert path.read_text() == "mine"
    assert writer.path != path
    np.testing.assert_array_equal(open_recording(writer.path).values.ravel(), OLD)


@posix
def test_a_link_to_a_recording_stays_a_link_when_its_target_is_overwritten(path: Path) -> None:
    write(path, OLD)
    link = path.with_name("latest.h5")
    link.symlink_to(path.name)
    write(link, NEW, overwrite=True)
    assert link.is_symlink()
    np.testing.assert_array_equal(open_recording(path).values.ravel(), NEW)


def test_where_open_files_cannot_be_renamed_the_file_is_closed_for_it(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("instrument.storage.part.RENAMES_OPEN_FILES", False)
    write(path, OLD)
    write(path, NEW, overwrite=True)
    np.testing.assert_array_equal(open_recording(path).values.ravel(), NEW)
    assert list(path.parent.iterdir()) == [path]


def test_where_there_are_no_hard_links_a_new_name_is_taken_all_the_same(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def no_links(*_arguments: object, **_options: object) -> None:
        raise PermissionError("a stick")

    monkeypatch.setattr("instrument.storage.part.os.link", no_links)
    write(path, OLD)
    np.testing.assert_array_equal(open_recording(path).values.ravel(), OLD)


STARTING = """
import os, signal, sys
import numpy as np
from pathlib import Path
from instrument.plan import Plan
from instrument.storage import RecordingWriter, open_recording

folder, kills = Path(sys.argv[1]), int(sys.argv[2])


def child(path, at):
    if (process := os.fork()) == 0:
        calls = 0

        def count(frame, event, what):
            nonlocal calls
            calls += 1
            if calls == at:
                os.kill(os.getpid(), signal.SIGKILL)

        sys.setprofile(count)
        writer = RecordingWriter(path, Plan(frames=8, image_size=8), picture_time_s=50e-6, overwrite=True)
        writer.append(1000 - np.arange(48.0))
        sys.setprofile(None)
        path.with_suffix(".calls").write_text(str(calls))
        os._exit(0)
    return os.waitpid(process, 0)[1]


def place(name):
    (folder / name).mkdir()
    if (folder / "old.h5").exists():
        (folder / name / "run.h5").write_bytes((folder / "old.h5").read_bytes())
    return folder / name / "run.h5"


whole = place("whole")
assert child(whole, 0) == 0
calls = int(whole.with_suffix(".calls").read_text())
for kill in range(kills):
    assert child(place(str(kill)), 1 + kill * (calls - 2) // (kills - 1)) == signal.SIGKILL
"""


@posix
@pytest.mark.parametrize("old", [pytest.param(False, marks=pytest.mark.thorough), True])
def test_a_run_killed_before_its_first_block_blocks_nothing(tmp_path: Path, *, old: bool) -> None:
    """Fifty kills from the beginning to the first block: the old recording whole, or the new one with what it has."""
    if old:
        write(tmp_path / "old.h5", OLD)
    kills, begun = 50, 0
    subprocess.run([sys.executable, "-c", STARTING, str(tmp_path), str(kills)], check=True)
    for kill in range(kills):
        left = tmp_path / str(kill) / "run.h5"
        if left.exists():
            values = open_recording(left).values.ravel()
            if len(values) == 48 and values[0] == 0:
                assert old
                np.testing.assert_array_equal(values, OLD)
            else:
                begun += 1
                np.testing.assert_array_equal(values[np.isfinite(values)], NEW[: np.isfinite(values).sum()])
        write(left, NEW, overwrite=left.exists())
        assert list(left.parent.iterdir()) == [left]
    assert 0 < begun < kills // 2


def test_an_interrupt_while_the_file_is_made_leaves_nothing(path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def interrupt(*_arguments: object) -> None:
        raise KeyboardInterrupt

    monkeypatch.setattr("instrument.storage.empty_recording._add_what_grows", interrupt)
    with pytest.raises(KeyboardInterrupt):
        RecordingWriter(path, PLAN, picture_time_s=50e-6)
    assert list(path.parent.iterdir()) == []


@posix
def test_what_a_program_that_died_left_is_told_and_removed(path: Path) -> None:
    """And nothing else: neither a link nor a name that only looks like one."""
    left = path.with_name(f".run.h5.recorded-4321-{'a' * 16}.part")
    left.write_bytes(b"half a file")
    others = [
        path.with_name(f".run.h5.recorded-4321-{'b' * 15}.part"),
        path.with_name(f".x.h5.recorded-1-{'a' * 16}.part"),
    ]
    for other in others:
        other.write_text("mine")
    link = path.with_name(f".run.h5.recorded-4321-{'c' * 16}.part")
    link.symlink_to(others[0])
    assert remains_of(path) == [left]
    with RecordingWriter(path, PLAN, picture_time_s=50e-6) as writer:
        writer.append(OLD)
        writer.finish()
    assert writer.removed == (left,)
    assert sorted(path.parent.iterdir()) == sorted([path, link, *others])


HOLDER = """
import sys, h5py
file = h5py.File(sys.argv[1], "r+")
print("open", flush=True)
sys.stdin.readline()
"""


@contextmanager
def held(path: Path) -> Generator[subprocess.Popen[str]]:
    """Another program that has the file open for writing."""
    with subprocess.Popen(
        [sys.executable, "-c", HOLDER, str(path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    ) as program:
        assert program.stdout is not None
        assert program.stdout.readline() == "open\n"
        yield program
        program.communicate("\n", timeout=20)


@posix
def test_a_file_that_another_program_writes_is_in_use_and_not_damaged(path: Path) -> None:
    write(path, OLD)
    questions: list[Callable[[], object]] = [
        lambda: open_recording(path),
        lambda: refuse_while_written(path),
        lambda: refuse_unchangeable(path),
        lambda: write_analysis(path, displacement_px=np.ones((8, 2)), image=None),
    ]
    with held(path):
        for question in questions:
            with pytest.raises(InputError, match=r"run\.h5, which is in use by another program"):
                question()
    np.testing.assert_array_equal(open_recording(path).values.ravel(), OLD)


@posix
def test_a_file_whose_other_writer_died_says_so(path: Path) -> None:
    write(path, OLD)
    with held(path) as program:
        program.kill()
        program.wait(20)
        with pytest.raises(InputError, match="a program died while it changed the file, and did not close it"):
            open_recording(path)
