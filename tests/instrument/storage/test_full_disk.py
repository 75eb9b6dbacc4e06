"""A recording whose copy finds no room stays as it is, and the program lives on: a child meets a real limit of the system."""

import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from instrument.plan import Plan
from instrument.storage import RecordingWriter, open_recording

pytestmark = pytest.mark.skipif(sys.platform == "win32", reason="limits of a process are POSIX")

PLAN = Plan(frames=8, image_size=8)

LIMITED = """
import resource, signal, sys
from pathlib import Path
import numpy as np
from instrument.storage import write_analysis
from instrument.storage.edit import rewritten
from protocols import InputError

def at_most(size):
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, resource.RLIM_INFINITY))

path = Path(sys.argv[1])
"""


def said_by(script: str, path: Path) -> str:
    done = subprocess.run(
        [sys.executable, "-c", LIMITED + script, str(path)], capture_output=True, text=True, check=False, timeout=60
    )
    assert (done.returncode, done.stderr) == (0, "")
    return done.stdout


@pytest.fixture
def recorded(tmp_path: Path) -> Path:
    path = tmp_path / "run.h5"
    with RecordingWriter(path, PLAN, picture_time_s=50e-6) as writer:
        writer.append(np.arange(48.0))
        writer.finish(frame_valid=np.ones(8, bool), report="")
    return path


@pytest.mark.parametrize("kilobytes", [0, 4, 40, 200])
def test_an_analysis_without_room_is_refused_in_one_line(recorded: Path, kilobytes: int) -> None:
    before = recorded.read_bytes()
    said = said_by(
        f"""
at_most({kilobytes} * 1000)
try:
    write_analysis(path, displacement_px=np.zeros((8, 2)), image=np.zeros((8, 8)))
except InputError as error:
    print(str(error))
""",
        recorded,
    )
    needed = len(before) + 8 * (16 + 64 + 16) + 2 * len("{}") + 262_144
    assert said.startswith(
        f"saw no room for a copy of {recorded} with what is added, {needed / 1e6:.1f} MB: [Errno 27]"
    )
    assert said.count("\n") == 1
    assert recorded.read_bytes() == before
    assert list(recorded.parent.iterdir()) == [recorded]


def test_room_for_what_is_added_is_taken_too(recorded: Path) -> None:
    said = said_by(
        """
at_most(path.stat().st_size + 1_000_000)
try:
    with rewritten(path, more_bytes=700_000):
        print("begun")
    with rewritten(path, more_bytes=1_000_000):
        print("begun again")
except InputError as error:
    print("refused")
""",
        recorded,
    )
    assert said == "begun\nrefused\n"


def test_a_disk_that_is_full_in_the_middle_of_it_changes_nothing_and_crashes_nobody(recorded: Path) -> None:
    before = recorded.read_bytes()
    said = said_by(
        """
try:
    with rewritten(path, more_bytes=0) as entry:
        at_most(1000)
        entry.add("more", np.ones(100_000))
        print("it was taken for written")
except (OSError, RuntimeError):
    print("failed")
""",
        recorded,
    )
    assert said.endswith("failed\n")
    assert recorded.read_bytes() == before
    assert list(recorded.parent.iterdir()) == [recorded]
    assert len(open_recording(recorded)) == 8


def test_a_copy_occupies_no_more_than_it_is_long(recorded: Path) -> None:
    said_by("with rewritten(path, more_bytes=5_000_000):\n    pass\n", recorded)
    status = recorded.stat()
    assert 512 * status.st_blocks < status.st_size + 65536
