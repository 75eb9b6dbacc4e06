"""An analysis leaves the permissions, owner, links and attributes of its recording alone, whenever it is killed."""

import os
import stat
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from instrument.plan import Plan
from instrument.storage import RecordingWriter, open_recording, refuse_unchangeable, write_analysis
from protocols import InputError
from tests.support import plain_hdf5 as plain

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="permissions and links of POSIX")

PLAN = Plan(frames=8, image_size=8)
COUNTS = np.arange(48, dtype=np.float64)
TRACK, IMAGE = np.ones((8, 2)), np.eye(8)


@pytest.fixture
def path(tmp_path: Path) -> Path:
    path = tmp_path / "data" / "run.h5"
    path.parent.mkdir()
    with RecordingWriter(path, PLAN, picture_time_s=50e-6) as writer:
        writer.append(COUNTS)
        writer.finish()
    return path


@pytest.mark.parametrize("mode", [0o640, 0o600, 0o664, 0o4755])
def test_the_permissions_stay(path: Path, mode: int) -> None:
    path.chmod(mode)
    write_analysis(path, displacement_px=TRACK, image=IMAGE)
    assert stat.S_IMODE(path.stat().st_mode) == mode


def test_the_owner_stays(path: Path) -> None:
    if os.getuid() != 0:
        pytest.skip("only root can give a file away")
    os.chown(path, 1234, 2345)
    write_analysis(path, displacement_px=TRACK, image=IMAGE)
    assert (path.stat().st_uid, path.stat().st_gid) == (1234, 2345)


def test_extended_attributes_stay(path: Path) -> None:
    if sys.platform != "linux":
        pytest.skip("extended attributes of Linux")
    try:
        os.setxattr(path, "user.sample", b"letter B")
    except OSError:
        pytest.skip("this file system has none")
    write_analysis(path, displacement_px=TRACK, image=IMAGE)
    assert os.getxattr(path, "user.sample") == b"letter B"


def test_a_link_stays_a_link_and_its_target_is_analysed(path: Path, tmp_path: Path) -> None:
    link = tmp_path / "latest.h5"
    link.symlink_to(path)
    write_analysis(link, displacement_px=TRACK, image=IMAGE)
    assert link.readlink() == path
    np.testing.assert_array_equal(plain.array(path, "entry/analysis/image/image"), IMAGE)
    assert sorted(tmp_path.iterdir()) == [path.parent, link]
    assert list(path.parent.iterdir()) == [path]


def read_only(path: Path) -> str:
    path.chmod(0o444)
    return "run.h5, which is read-only"


def folder_read_only(path: Path) -> str:
    path.parent.chmod(0o555)
    return "run.h5 in a read-only folder"


def two_names(path: Path) -> str:
    path.with_name("same.h5").hardlink_to(path)
    return r"run.h5, a file of 2 names \(hard links\)"


@pytest.mark.parametrize("guard", [read_only, folder_read_only, two_names], ids=lambda guard: guard.__name__)
def test_what_is_not_to_be_changed_is_refused_and_a_copy_offered(
    path: Path, tmp_path: Path, guard: Callable[[Path], str]
) -> None:
    """The copy has the analysis and the permissions of the original; the original has every byte and time that it had."""
    what = guard(path)
    before, then = path.read_bytes(), path.stat()
    with pytest.raises(InputError, match=rf"{what}.*--results FILE"):
        refuse_unchangeable(path)
    with pytest.raises(InputError, match=what):
        write_analysis(path, displacement_px=TRACK, image=IMAGE)
    copy = tmp_path / "results.h5"
    write_analysis(path, displacement_px=TRACK, image=IMAGE, into=copy)
    now = path.stat()
    assert (now.st_mode, now.st_ino, now.st_mtime_ns, now.st_nlink) == (
        then.st_mode,
        then.st_ino,
        then.st_mtime_ns,
        then.st_nlink,
    )
    assert path.read_bytes() == before
    assert copy.stat().st_mode == then.st_mode
    np.testing.assert_array_equal(plain.array(copy, "entry/analysis/image/image"), IMAGE)
    np.testing.assert_array_equal(open_recording(copy).values.ravel(), COUNTS)
    path.parent.chmod(0o755)


def test_results_never_replace_a_file(path: Path, tmp_path: Path) -> None:
    other, dangling = tmp_path / "other.h5", tmp_path / "dangling.h5"
    other.write_text("mine")
    dangling.symlink_to(tmp_path / "nowhere.h5")
    for taken in (other, dangling, path):
        with pytest.raises(InputError, match=rf"{taken.name}, which exists; expected the name of a new file"):
            write_analysis(path, displacement_px=TRACK, image=IMAGE, into=taken)
    with pytest.raises(InputError, match="no folder"):
        write_analysis(path, displacement_px=TRACK, image=IMAGE, into=tmp_path / "no" / "x.h5")
    assert other.read_text() == "mine"
    assert not (tmp_path / "nowhere.h5").exists()


def test_a_recording_that_changes_while_its_analysis_is_stored_is_kept(
    path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def change(file: int) -> None:
        os.utime(path, ns=(0, 0))

    monkeypatch.setattr("instrument.storage.edit.os.fsync", change)
    with pytest.raises(InputError, match="changed while its analysis was stored"):
        write_analysis(path, displacement_px=TRACK, image=IMAGE)
    assert list(path.parent.iterdir()) == [path]
    assert open_recording(path).values.shape == (8, 6)


def test_a_planted_link_is_not_followed(path: Path, tmp_path: Path) -> None:
    """The name that a part of version 0.1 had, for this process."""
    victim = tmp_path / "victim"
    victim.write_text("precious")
    planted = path.with_name(f".run.h5.{os.getpid()}.part")
    planted.symlink_to(victim)
    write_analysis(path, displacement_px=TRACK, image=IMAGE)
    assert victim.read_text() == "precious"
    assert planted.is_symlink()


def test_a_name_that_is_taken_is_not_used(path: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Even a name that was guessed: it is created exclusively."""
    victim = tmp_path / "victim"
    victim.write_text("precious")

    def guessed(_bytes: int) -> str:
        return "0" * 16

    monkeypatch.setattr("instrument.storage.part.secrets.token_hex", guessed)
    path.with_name(f".run.h5.analysed-{os.getpid()}-{'0' * 16}.part").symlink_to(victim)
    with pytest.raises(InputError, match="where no file can be made"):
        write_analysis(path, displacement_px=TRACK, image=IMAGE)
    assert victim.read_text() == "precious"


KILLED = """
import os, shutil, signal, sys
import numpy as np
from pathlib import Path
from instrument.storage import write_analysis

source, kills = Path(sys.argv[1]), int(sys.argv[2])


def child(path, at):
    if (process := os.fork()) == 0:
        calls = 0

        def count(frame, event, what):
            nonlocal calls
            calls += 1
            if calls == at:
                os.kill(os.getpid(), signal.SIGKILL)

        sys.setprofile(count)
        write_analysis(path, displacement_px=np.ones((8, 2)), image=np.eye(8))
        sys.setprofile(None)
        path.with_suffix(".calls").write_text(str(calls))
        os._exit(0)
    return os.waitpid(process, 0)[1]


def copy(name):
    (source.parent / name).mkdir()
    return Path(shutil.copy(source, source.parent / name / "run.h5"))


whole = copy("whole")
assert child(whole, 0) == 0
calls = int(whole.with_suffix(".calls").read_text())
for kill in range(kills):
    assert child(copy(str(kill)), 1 + kill * (calls - 2) // (kills - 1)) == signal.SIGKILL
print(calls)
"""


def test_an_analysis_killed_at_any_moment_leaves_the_old_file_or_the_new_one(path: Path) -> None:
    """Sixty kills, spread over all calls of Python from the first to the last. The next analysis cleans up."""
    before = path.read_bytes()
    kills = 60
    done = subprocess.run([sys.executable, "-c", KILLED, str(path), str(kills)], check=True, capture_output=True)
    assert int(done.stdout) > kills
    old = 0
    for kill in range(kills):
        left = path.parent / str(kill) / "run.h5"
        np.testing.assert_array_equal(open_recording(left).values.ravel(), COUNTS)
        if left.read_bytes() == before:
            old += 1
        else:
            np.testing.assert_array_equal(plain.array(left, "entry/analysis/image/image"), IMAGE)
        write_analysis(left, displacement_px=2 * TRACK, image=IMAGE)
        assert list(left.parent.iterdir()) == [left]
    assert 0 < old < kills
