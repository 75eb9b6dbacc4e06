"""A file that is no readable recording is refused with its name and what is wrong with it."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from instrument.plan import Plan
from instrument.storage import RecordingWriter, open_recording
from protocols import InputError
from tests.support import plain_hdf5 as plain


def truncated(path: Path) -> str:
    raw = path.read_bytes()
    path.write_bytes(raw[: len(raw) // 2])
    return "a truncated file"


def empty(path: Path) -> str:
    path.write_bytes(b"")
    return "an empty file"


def text(path: Path) -> str:
    path.write_text("frame,value\n0,1\n")
    return "something else than an HDF5 file"


def damaged(path: Path) -> str:
    raw = bytearray(path.read_bytes())
    raw[64:1024] = bytes(960)
    path.write_bytes(raw)
    return "a damaged file"


def foreign(path: Path) -> str:
    with plain.opened(path, "w") as file:
        file["x"] = 1
    return "an HDF5 file by another program"


def later(path: Path) -> str:
    with plain.opened(path, "r+") as file:
        file["entry/definition"].attrs["version"] = "2.0"
    return "layout 2.0, while this program reads 1.3"


def no_values(path: Path) -> str:
    with plain.opened(path, "r+") as file:
        del file["entry/data/values"]
    return "a damaged file"


def narrow(path: Path) -> str:
    with plain.opened(path, "r+") as file:
        del file["entry/data/values"]
        file["entry/data/values"] = np.zeros((8, 5))
    return r"values of shape \(8, 5\)"


def strange_plan(path: Path) -> str:
    with plain.opened(path, "r+") as file:
        file["entry/plan"][()] = '{"scheme": "holography"}'
    return "a plan that this program does not know"


def short_mask(path: Path) -> str:
    with plain.opened(path, "r+") as file:
        del file["entry/timing/frame_valid"]
        file["entry/timing/frame_valid"] = np.ones(5, np.uint8)
    return "a mask of 5 frames for 8 frames"


def gone(path: Path) -> str:
    path.unlink()
    return "no such file"


def folder(path: Path) -> str:
    path.unlink()
    path.mkdir()
    return "a folder"


@pytest.mark.parametrize(
    "harm",
    [truncated, empty, text, damaged, foreign, later, no_values, narrow, strange_plan, short_mask, gone, folder],
    ids=lambda harm: harm.__name__,
)
def test_a_file_that_is_no_good_is_named_with_what_is_wrong(tmp_path: Path, harm: Callable[[Path], str]) -> None:
    path = tmp_path / "run.h5"
    with RecordingWriter(path, Plan(frames=8, image_size=8), picture_time_s=50e-6) as writer:
        writer.append(np.zeros(48))
        writer.finish()
    what = harm(path)
    with pytest.raises(InputError, match=what) as caught:
        open_recording(path)
    assert str(path) in str(caught.value)
    assert caught.value.exit_code == 2
