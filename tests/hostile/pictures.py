"""Files that are called pictures and arrays and were made to do harm, each small and each made here."""

import io
import struct
import zlib
from collections.abc import Iterator
from pathlib import Path

import numpy as np
from PIL import Image

PNG = b"\x89PNG\r\n\x1a\n"


def chunk(kind: bytes, data: bytes) -> bytes:
    """One part of a PNG, with its length before and its checksum behind."""
    return struct.pack(">I", len(data)) + kind + data + struct.pack(">I", zlib.crc32(kind + data))


def png(width: int, height: int, *, bits: int = 8, colour: int = 0, extra: bytes = b"") -> bytes:
    """A black PNG of any size, in 1/1000 of it: rows are compressed one after the other."""
    channels = {0: 1, 2: 3, 3: 1, 4: 2, 6: 4}[colour]
    row = b"\0" * (1 + -(-width * channels * bits // 8))
    packer = zlib.compressobj(9)
    data = b"".join(packer.compress(row) for _ in range(height)) + packer.flush()
    header = struct.pack(">IIBBBBB", width, height, bits, colour, 0, 0, 0)
    return PNG + chunk(b"IHDR", header) + extra + chunk(b"IDAT", data) + chunk(b"IEND", b"")


def npy(header: str | bytes, data: bytes = b"", *, version: tuple[int, int] = (1, 0)) -> bytes:
    """An NPY file with a header of one's own."""
    text = header if isinstance(header, bytes) else header.encode("latin1")
    length = struct.pack("<H" if version == (1, 0) else "<I", len(text))
    return b"\x93NUMPY" + bytes(version) + length + text + data


def described(shape: object, dtype: str = "<f8", order: str = "False") -> str:
    """The header of an array."""
    return f"{{'descr': {dtype!r}, 'fortran_order': {order}, 'shape': {shape!r}, }}\n"


def not_pictures() -> Iterator[tuple[str, bytes]]:
    """Files of another kind, and the words by which each is to be refused."""
    eps = b"%!PS-Adobe-3.0 EPSF-3.0\n%%BoundingBox: 0 0 8 8\n(harm) print\n"
    yield "a PostScript program", eps
    yield "a PostScript program", b"\xc5\xd0\xd3\xc6" + struct.pack("<IIIIIIH", 30, len(eps), 0, 0, 0, 0, 0xFFFF) + eps
    yield "a PDF document", b"%PDF-1.7\n"
    npz = io.BytesIO()
    np.savez_compressed(npz, cells=np.ones((2, 2)))
    yield "an archive (ZIP or NPZ)", npz.getvalue()
    for words, kind in (("JPEG", "JPEG"), ("GIF", "GIF"), ("BMP", "BMP"), ("TIFF", "TIFF")):
        stream = io.BytesIO()
        Image.fromarray(np.full((2, 2), 200, np.uint8)).save(stream, format=kind)
        yield f"a {words} picture", stream.getvalue()
    yield "neither PNG nor NPY", b""
    yield "neither PNG nor NPY", b"\x80\x05K\x01."  # a pickle


def broken_arrays() -> Iterator[tuple[str, bytes]]:
    """NPY files whose header lies, and the words by which each is to be refused."""
    yield "promises 8000000", npy(described((1000, 1000)))
    yield "pixels", npy(described((10**9, 10**9)))
    yield "pixels", npy(described((2**40, 2**40)))
    yield "an array of object", npy(described((2, 2), "|O"), b"\x80\x05K\x01.")
    yield "an array of", npy(described((2, 2), "<U100000000"))
    yield "an array of", npy(described((2, 2), "<M8[s]"), bytes(32))
    yield "shape", npy(described((-1, 4)), bytes(32))
    yield "shape", npy(described((0, 4)))
    yield "shape", npy(described(()), bytes(8))
    yield "shape", npy(described((4,)), bytes(32))
    yield "broken header", npy("{}\n")
    yield "broken header", npy(described((2.0, 2)), bytes(32))
    yield "broken header", npy(described((2, 2), order="1.5"), bytes(32))
    yield "broken header", npy("__import__('os').system('true')\n")
    yield "broken header", npy("(" * 9000 + "\n")
    yield "broken header", npy("[" * 9000 + "]" * 9000 + "\n", version=(2, 0))
    yield "broken header", npy(b"'" * 60_001)
    yield "broken header", npy(described((2, 2)), bytes(32), version=(3, 0))
    yield "broken header", npy(described((2, 2)), bytes(32), version=(9, 9))
    yield "broken header", b"\x93NUMPY"
    yield "broken header", b"\x93NUMPY\x02\x00\xff\xff\xff\xff"


def damaged(whole: bytes, how_many: int, seed: int) -> Iterator[bytes]:
    """A file cut short, or with some of its bytes changed."""
    random = np.random.default_rng(seed)
    for _ in range(how_many):
        changed = bytearray(whole)
        for at in random.integers(8, len(whole), random.integers(1, 9)):
            changed[at] = random.integers(256)
        yield bytes(changed[: random.integers(9, len(whole))] if random.random() < 0.3 else changed)


def strange_files(folder: Path) -> Iterator[tuple[str, str]]:
    """What a name can lead to that is no file: its name, and the words by which it is to be refused."""
    (folder / "folder.png").mkdir()
    yield "folder.png", "a folder"
    (folder / "circle.png").symlink_to("circle.png")
    yield "circle.png", "symbolic links"
    yield "x" * 300 + ".png", "name too long"
