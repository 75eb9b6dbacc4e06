"""A run whose program is killed keeps what it had counted: the reason why files are written in SWMR mode."""

import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from instrument.storage import open_recording, write_analysis
from protocols import InputError
from tests.support import plain_hdf5 as plain

KILLED = """
import os, signal, sys
import numpy as np
from pathlib import Path
from instrument.plan import Plan
from instrument.storage import RecordingWriter
from protocols import CountBlock

writer = RecordingWriter(Path(sys.argv[1]), Plan(frames=2000, image_size=8), picture_time_s=50e-6)
for first in range(0, 7000, 1000):
    values = np.arange(first, first + 1000)
    edges = values * 50e-6
    closing = (first + 1000) * 50e-6
    writer.append_raw(CountBlock(first, values.astype(np.uint32), opening_edge_s=edges, closing_edge_s=closing))
    writer.append(values.astype(np.float64), edges)
os.kill(os.getpid(), getattr(signal, "SIGKILL", signal.SIGTERM))
"""


@pytest.fixture(scope="session")
def left_behind(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """What a program left that killed itself after seven blocks of a thousand patterns."""
    path = tmp_path_factory.mktemp("killed") / "run.h5"
    assert subprocess.run([sys.executable, "-c", KILLED, str(path)], check=False).returncode != 0
    return path


@pytest.fixture
def path(left_behind: Path, tmp_path: Path) -> Path:
    """A copy to do with as one likes."""
    return Path(shutil.copy(left_behind, tmp_path))


def test_a_killed_run_keeps_every_block_that_was_appended(path: Path) -> None:
    recording = open_recording(path)
    assert len(recording) == 1167
    np.testing.assert_array_equal(recording.values.ravel()[:7000], np.arange(7000))
    assert np.isnan(recording.values.ravel()[7000:]).all()
    assert recording.frame_valid.sum() == 1166
    assert recording.edge_time_s is not None
    assert recording.edge_time_s[1166, 3] == 6999 * 50e-6
    assert recording.photon_counts


def test_a_killed_recording_can_be_analysed_and_is_sound_again(path: Path) -> None:
    with pytest.raises(OSError, match="already open for write"):
        plain.opened(path)

    write_analysis(path, displacement_px=np.zeros((1167, 2)), image=np.eye(8))

    assert plain.array(path, "entry/data/values").shape == (1167, 6)
    assert plain.attribute(path, "entry", "complete") == 0
    assert len(open_recording(path)) == 1167


def test_a_killed_run_that_is_also_truncated_is_refused(path: Path) -> None:
    """HDF5 does not check the length of a file that was left open, and gives zeros for what is missing."""
    raw = path.read_bytes()
    path.write_bytes(raw[: len(raw) // 2])
    with pytest.raises(InputError, match=r"a truncated file .*goes on to byte"):
        open_recording(path)


BUSY = """
import sys
import numpy as np
from pathlib import Path
from instrument.plan import Plan
from instrument.storage import RecordingWriter

writer = RecordingWriter(Path(sys.argv[1]), Plan(frames=1_000_000, image_size=8), picture_time_s=50e-6)
for first in range(0, 6_000_000, 100):
    values = np.arange(first, first + 100, dtype=np.float64)
    writer.append(values, values * 50e-6)
    if first == 20_000:
        print(first, flush=True)
"""


def test_a_run_killed_in_the_middle_of_writing_is_still_readable(tmp_path: Path) -> None:
    """The writer never pauses, so the kill falls somewhere inside a write."""
    path = tmp_path / "run.h5"
    with subprocess.Popen([sys.executable, "-c", BUSY, str(path)], stdout=subprocess.PIPE) as writer:
        assert writer.stdout is not None
        assert writer.stdout.readline() == b"20000\n"
        writer.kill()

    recording = open_recording(path)

    values = recording.values.ravel()
    measured = np.flatnonzero(np.isfinite(values))
    assert len(measured) >= 20_100
    np.testing.assert_array_equal(values[measured], measured)
    assert len(values) - len(measured) < 6 + 100
