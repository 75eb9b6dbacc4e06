"""A recording is finished in the file that was begun: whoever reads it keeps it, and no analysis takes it from its writer."""

import errno
import os
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from instrument.plan import Plan
from instrument.storage import RecordingWriter, open_recording, write_analysis
from protocols import InputError, Truth
from tests.support import plain_hdf5 as plain

PLAN = Plan(frames=8, image_size=8)
COUNTS = np.arange(48, dtype=np.float64)

READER = """
import sys, h5py
file = h5py.File(sys.argv[1], "r", swmr=True)
values, valid = file["entry/data/values"], file["entry/timing/frame_valid"]
print(values.shape[0], valid.shape[0], flush=True)
sys.stdin.readline()
for dataset in (values, valid, file["entry/timing/report"], file["entry/truth/displacement_px"], file["entry/end_time"]):
    dataset.refresh()
print(values.shape[0], valid[:].tolist(), file["entry/timing/report"].asstr()[()], len(file["entry/end_time"].asstr()[()]),
      file["entry/truth/displacement_px"].shape, values[7, 5], flush=True)
"""


def test_a_reader_in_another_process_keeps_the_file_through_the_end(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    with RecordingWriter(path, PLAN, picture_time_s=50e-6, with_truth=True) as writer:
        writer.append(COUNTS[:12])
        inode = path.stat().st_ino
        with subprocess.Popen(
            [sys.executable, "-c", READER, str(path)], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
        ) as reader:
            assert reader.stdout is not None
            assert reader.stdout.readline() == "2 0\n"
            writer.append(COUNTS[12:])
            truth = Truth(displacement_px=np.ones((8, 2)), image=np.eye(8))
            writer.finish(report='{"gaps": []}', truth=truth)
            said, _ = reader.communicate("\n", timeout=20)
    assert said == '8 [1, 1, 1, 1, 1, 1, 1, 1] {"gaps": []} 29 (8, 2) 47.0\n'
    assert path.stat().st_ino == inode
    assert plain.attribute(path, "entry", "complete") == 1


def test_an_analysis_is_refused_while_the_run_goes_on(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    with RecordingWriter(path, PLAN, picture_time_s=50e-6) as writer:
        writer.append(COUNTS)
        with pytest.raises(InputError, match=rf"being recorded by process {os.getpid()} since 20\d\d-") as caught:
            write_analysis(path, displacement_px=np.zeros((8, 2)), image=np.eye(8))
        assert caught.value.exit_code == 2
        writer.finish()
    with plain.opened(path):  # a reader is no writer
        write_analysis(path, displacement_px=np.zeros((8, 2)), image=np.eye(8))
    assert plain.array(path, "entry/analysis/image/image").shape == (8, 8)


def test_a_second_run_into_the_same_file_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    with RecordingWriter(path, PLAN, picture_time_s=50e-6) as writer:
        writer.append(COUNTS)
        with pytest.raises(InputError, match=rf"being recorded by process {os.getpid()} since 20\d\d-"):
            RecordingWriter(path, PLAN, picture_time_s=50e-6, overwrite=True)
        writer.finish()
    assert len(open_recording(path)) == 8


FINISHING = """
import os, signal, sys
import numpy as np
from pathlib import Path
from instrument.plan import Plan
from instrument.storage import RecordingWriter, hdf5, hdf5_file

steps = int(sys.argv[2])
writer = RecordingWriter(Path(sys.argv[1]), Plan(frames=8, image_size=8), picture_time_s=50e-6)
writer.append(np.arange(48, dtype=np.float64))
done = 0


def killing(method):
    def call(*arguments):
        global done
        if done == steps:
            os.kill(os.getpid(), getattr(signal, "SIGKILL", signal.SIGTERM))
        done += 1
        return method(*arguments)
    return call


for owner, name in ((hdf5.Group, "set_value"), (hdf5.Group, "set_attribute"), (hdf5.Growing, "write"), (hdf5_file.File, "close")):
    setattr(owner, name, killing(getattr(owner, name)))
writer.finish(report='{"gaps": []}')
"""


@pytest.mark.parametrize("steps", range(10))
def test_a_program_killed_while_it_finishes_leaves_every_value(tmp_path: Path, steps: int) -> None:
    """Nine steps; all are done where it is killed at the tenth, which does not come."""
    path = tmp_path / "run.h5"
    done = subprocess.run([sys.executable, "-c", FINISHING, str(path), str(steps)], check=False)
    assert (done.returncode == 0) == (steps == 9)
    recording = open_recording(path)
    np.testing.assert_array_equal(recording.values.ravel(), COUNTS)
    assert recording.frame_valid.all()
    write_analysis(path, displacement_px=np.zeros((8, 2)), image=np.eye(8))
    assert plain.attribute(path, "entry", "complete") == (steps >= 8)


def test_a_reason_that_is_too_long_is_cut_and_a_report_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "run.h5"
    with RecordingWriter(path, PLAN, picture_time_s=50e-6) as writer:
        writer.append(COUNTS)
        with pytest.raises(ValueError, match="65537 bytes for timing/report, which has room for 65536"):
            writer.finish(report="x" * 65_537)
        with pytest.raises(ValueError, match="opened without one"):
            writer.finish(truth=Truth(displacement_px=np.ones((8, 2)), image=np.eye(8)))
        writer.finish(interrupted="ä" * 3000)
    said = plain.text(path, "entry/interrupted")
    assert len(said.encode()) <= 4096
    assert said.endswith("ä...")


def test_a_recording_of_layout_1_0_is_read_as_before(tmp_path: Path) -> None:
    """There, what is not known is missing."""
    path = tmp_path / "run.h5"
    with RecordingWriter(path, PLAN, picture_time_s=50e-6) as writer:
        writer.append(COUNTS)
        writer.finish()
    with plain.opened(path, "r+") as file:
        for name in ("timing", "end_time", "interrupted", "file_bytes", "checksum"):
            del file["entry"][name]
        file["entry/definition"].attrs["version"] = "1.0"
    recording = open_recording(path)
    assert recording.frame_valid.all()
    assert recording.timing is None
    write_analysis(path, displacement_px=np.zeros((8, 2)), image=np.eye(8))


def test_a_file_that_cannot_take_its_place_is_left_beside_it(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It was asked for its place for the last time: what it holds is looked for there, so nothing removes it any more."""

    def refuse(_part: object, *, replace: bool) -> None:
        raise OSError(errno.EROFS, "a disk that was mounted again to be read only")

    writer = RecordingWriter(tmp_path / "run.h5", PLAN, picture_time_s=50e-6)
    monkeypatch.setattr("instrument.storage.part.Part.put_in_place", refuse)
    with pytest.raises(OSError, match="read only"):
        writer.append(COUNTS)
    with pytest.raises(OSError, match="read only"):
        writer.abandon()
    writer.close()
    (left,) = tmp_path.iterdir()
    assert left.suffix == ".part"
