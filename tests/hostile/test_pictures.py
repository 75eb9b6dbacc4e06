"""An object or a background that was made to do harm is refused in words, quickly, and in little memory."""

import os
import socket
import subprocess
import sys
import zlib
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from protocols import InputError
from sim_backends.bench.pictures import MOST_CELLS, read_cells
from tests.hostile.pictures import broken_arrays, chunk, damaged, not_pictures, npy, png, strange_files


def refusal(path: Path) -> str:
    with pytest.raises(InputError) as caught:
        read_cells(path)
    message = str(caught.value)
    assert str(path) in message
    return message


def read_or_refused(path: Path) -> bool:
    try:
        cells = read_cells(path)
    except InputError as error:
        return str(path) in str(error)
    return bool(0 <= cells.min() <= cells.max() <= 1)


def limited(memory_mb: int, statement: str) -> str:
    """Run a statement in a process that may take so much memory, and give what it says of itself at the end."""
    code = (
        "import resource\n"
        f"resource.setrlimit(resource.RLIMIT_AS, ({memory_mb} << 20, {memory_mb} << 20))\n"
        "from pathlib import Path\n"
        "from protocols import InputError\n"
        "from sim_backends.bench.pictures import read_cells\n"
        f"try:\n    print('read', ({statement}).shape)\nexcept InputError as error:\n    print('refused', error)\n"
    )
    environment = {**os.environ, "OPENBLAS_NUM_THREADS": "1"}
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=False, timeout=60, env=environment
    )
    return done.stdout + done.stderr


@pytest.mark.parametrize("suffix", ["png", "npy"])
def test_what_is_no_picture_is_refused_by_what_it_is(tmp_path: Path, suffix: str) -> None:
    path = tmp_path / f"object.{suffix}"
    for words, data in not_pictures():
        path.write_bytes(data)
        assert words in refusal(path)


def test_a_postscript_program_starts_no_interpreter(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    def start(*_arguments: object, **_options: object) -> None:
        raise AssertionError("a program was started")

    monkeypatch.setattr(subprocess, "Popen", start)
    monkeypatch.setattr(os, "system", start)
    for _, data in not_pictures():
        (tmp_path / "object.png").write_bytes(data)
        refusal(tmp_path / "object.png")


def test_a_picture_is_measured_before_it_is_unpacked(tmp_path: Path) -> None:
    path = tmp_path / "bomb.png"
    path.write_bytes(png(16_000, 13_000, bits=1))  # 208 million pixels
    assert path.stat().st_size < 50_000
    assert "a picture of 16000 x 13000 pixels" in limited(700, f"read_cells(Path({str(path)!r}))")


@pytest.mark.parametrize(("width", "height"), [(0, 0), (2**31 - 1, 2**31 - 1), (2**31 - 1, 1)])
def test_a_header_can_promise_anything(tmp_path: Path, width: int, height: int) -> None:
    path = tmp_path / "lie.png"
    whole = bytearray(png(8, 8))
    whole[16:24] = width.to_bytes(4) + height.to_bytes(4)
    path.write_bytes(whole)
    assert f"{width} x {height}" in refusal(path)


def test_the_largest_picture_is_read_in_less_than_two_gigabytes(tmp_path: Path) -> None:
    path = tmp_path / "large.png"
    path.write_bytes(png(8000, MOST_CELLS // 8000, colour=6))
    assert "read (4000, 8000)" in limited(2000, f"read_cells(Path({str(path)!r}))")


def test_a_text_that_unpacks_to_gigabytes_is_not_unpacked(tmp_path: Path) -> None:
    path = tmp_path / "text.png"
    path.write_bytes(png(8, 8, extra=chunk(b"zTXt", b"note\0\0" + zlib.compress(bytes(100_000_000)))))
    assert "text.png" in limited(700, f"read_cells(Path({str(path)!r}))")


def test_a_damaged_picture_is_read_or_refused(tmp_path: Path) -> None:
    path = tmp_path / "damaged.png"
    plain = np.random.default_rng(1).integers(0, 256, (16, 16), np.uint8)
    palette = Image.fromarray(plain).convert("P")
    for seed, picture in enumerate([Image.fromarray(plain), palette, Image.fromarray(plain.astype(np.uint16) * 257)]):
        picture.save(path)
        for data in damaged(path.read_bytes(), 150, seed):
            path.write_bytes(data)
            assert read_or_refused(path)


def test_a_wrong_checksum_is_told(tmp_path: Path) -> None:
    whole = bytearray(png(8, 8))
    whole[-17] ^= 1  # of the pixels
    (tmp_path / "crc.png").write_bytes(whole)
    assert "a damaged PNG" in refusal(tmp_path / "crc.png")


def test_an_array_whose_header_lies_is_refused_before_room_is_taken(tmp_path: Path) -> None:
    path = tmp_path / "cells.npy"
    for words, data in broken_arrays():
        path.write_bytes(data)
        assert words in refusal(path)


def test_a_damaged_array_is_read_or_refused(tmp_path: Path) -> None:
    path = tmp_path / "damaged.npy"
    np.save(path, np.full((4, 4), 0.5))
    for data in damaged(path.read_bytes(), 300, 7):
        path.write_bytes(data)
        assert read_or_refused(path)


def test_an_array_stored_by_columns_is_the_same_array(tmp_path: Path) -> None:
    cells = np.linspace(0, 1, 6).reshape(2, 3)
    np.save(tmp_path / "columns.npy", np.asfortranarray(cells))
    assert read_cells(tmp_path / "columns.npy").tolist() == cells.tolist()
    header = "{'descr': '>i2', 'fortran_order': False, 'shape': (1, 2), }\n"
    (tmp_path / "big-endian.npy").write_bytes(npy(header, bytes([0, 0, 0, 1]), version=(2, 0)))
    assert read_cells(tmp_path / "big-endian.npy").tolist() == [[0.0, 1.0]]


def test_what_is_no_file_is_refused_by_what_it_is(tmp_path: Path) -> None:
    for name, words in strange_files(tmp_path):
        assert words in refusal(tmp_path / name)


@pytest.mark.skipif(sys.platform == "win32", reason="Windows has no such files")
def test_pipes_devices_and_sockets_are_refused_without_waiting(tmp_path: Path) -> None:
    os.mkfifo(tmp_path / "pipe.png")
    assert "a named pipe (FIFO)" in refusal(tmp_path / "pipe.png")
    (tmp_path / "zero.npy").symlink_to("/dev/zero")
    assert "a device" in refusal(tmp_path / "zero.npy")
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(str(tmp_path / "socket.png"))
        assert "a socket" in refusal(tmp_path / "socket.png")


def test_a_file_of_a_terabyte_is_refused_by_its_size(tmp_path: Path) -> None:
    with (tmp_path / "sparse.npy").open("wb") as stream:
        stream.truncate(10**12)
    assert "1000000000000 bytes" in refusal(tmp_path / "sparse.npy")
