"""Room on the disk is taken before it is needed, and given back."""

import ctypes
import errno
import os
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

from instrument.storage import room
from instrument.storage.room import AHEAD, Room

linux = pytest.mark.skipif(sys.platform != "linux", reason="fallocate is Linux")


@linux
def test_blocks_are_allocated_ahead_and_the_length_stays(tmp_path: Path) -> None:
    path = tmp_path / "run"
    with path.open("wb") as file:
        file.write(b"x" * 100)
        file.flush()
        taken = Room(path, file.fileno())
        taken.take(1000)
        status = path.stat()
        assert status.st_size == 100
        assert 512 * status.st_blocks >= AHEAD + 1000
        assert not taken.lost()
        os.truncate(path, 50)
        os.truncate(path, 100)
        assert taken.lost()
        taken.take(AHEAD + 2000)
        assert not taken.lost()
        taken.give_back()
        assert not taken.lost()
        assert path.stat().st_size == 100
        assert 512 * path.stat().st_blocks < 1 << 16


@linux
def test_no_more_is_taken_than_is_needed_where_there_is_no_more(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[int] = []

    def fallocate(_file: int, mode: int, offset: int, length: int) -> int:
        assert (mode, offset) == (1, 0)
        asked.append(length)
        ctypes.set_errno(errno.ENOSPC)
        return 0 if length <= 5000 else -1

    monkeypatch.setattr(room, "_FALLOCATE", fallocate)
    with (tmp_path / "run").open("wb") as file:
        taken = Room(tmp_path / "run", file.fileno())
        taken.take(5000)
        taken.take(4000)
        assert asked == [AHEAD + 5000, 5000]
        with pytest.raises(OSError, match="No space left") as caught:
            taken.take(5001)
    assert caught.value.errno == errno.ENOSPC


@linux
def test_where_blocks_cannot_be_allocated_the_free_room_is_looked_at(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    def fallocate(*_arguments: int) -> int:
        ctypes.set_errno(errno.EOPNOTSUPP)
        return -1

    def disk_usage(_folder: Path) -> SimpleNamespace:
        return SimpleNamespace(free=900)

    monkeypatch.setattr(room, "_FALLOCATE", fallocate)
    monkeypatch.setattr("instrument.storage.room.shutil.disk_usage", disk_usage)
    with (tmp_path / "run").open("wb") as file:
        os.ftruncate(file.fileno(), 100)
        taken = Room(tmp_path / "run", file.fileno())
        taken.take(1000)
        with pytest.raises(OSError, match="900 bytes free"):
            taken.take(1001)


def test_the_longest_file_that_the_system_allows_is_respected(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(room, "longest_file", lambda: 2000.0)
    with (tmp_path / "run").open("wb") as file:
        taken = Room(tmp_path / "run", file.fileno())
        taken.take(2000)
        with pytest.raises(OSError, match="the system allows files of 2000 bytes") as caught:
            taken.take(2001)
    assert caught.value.errno == errno.EFBIG
