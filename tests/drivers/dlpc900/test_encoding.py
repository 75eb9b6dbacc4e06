"""Images, by the guide's own bytes and by a decoder that was written apart."""

import time

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from drivers.dlpc900.encoding import image
from protocols import Bytes
from sim_backends.wire.dlpc900.picture import BadImage, decode


def planes(n: int, rows: int, columns: int, seed: int = 0) -> list[Bytes]:
    return list(np.random.default_rng(seed).integers(0, 256, (n, rows, columns // 8), np.uint8))


def test_the_header_is_that_of_the_guide() -> None:
    """Table 2-106: signature, width, height, size, eight FF, background, 00, compression, 01, and 21 zeros."""
    data = image([np.zeros((4, 2), np.uint8)], "rgb")
    assert data[:8] == b"Spld\x10\x00\x04\x00"
    assert int.from_bytes(data[8:12], "little") == len(data) - 48
    assert data[12:48] == b"\xff" * 8 + bytes(4) + b"\x00\x02\x01" + bytes(21)


def test_runs_and_equal_lines_are_the_codes_of_the_guide() -> None:
    """A line of 8 lit and 8 dark mirrors, the same line again, and the end, filled up to four bytes."""
    data = image([np.array([[0xFF, 0x00], [0xFF, 0x00]], np.uint8)], "rgb")
    assert data[48:] == b"\x08\x00\x00\x01" + b"\x08\x00\x00\x00" + b"\x00\x01\x10" + b"\x00\x01\x00" + bytes(2)


def test_a_long_run_has_two_bytes_of_length() -> None:
    """130 is 82 01 (Table 2-110)."""
    lit = np.packbits(np.r_[np.ones(130, np.uint8), np.zeros(6, np.uint8)])[None]
    assert image([lit], "rgb")[48:].startswith(b"\x82\x01\x00\x00\x01\x06\x00\x00\x00")


def test_single_pixels_are_written_out() -> None:
    lit = np.array([[0b10100000]], np.uint8)
    code = image([lit], "rgb")
    assert code[25] == 2 or code[25] == 0
    assert decode(code, 8, 1).plane(0, "rgb").tolist() == [[0b10100000]]


@pytest.mark.parametrize(
    ("plane", "order", "pixel"),
    [
        (0, "rgb", b"\x00\x00\x01"),
        (7, "rgb", b"\x00\x00\x80"),
        (8, "rgb", b"\x00\x01\x00"),
        (23, "rgb", b"\x80\x00\x00"),
        (8, "grb", b"\x01\x00\x00"),
        (16, "grb", b"\x00\x01\x00"),
        (3, "grb", b"\x00\x00\x08"),
    ],
)
def test_each_plane_is_one_bit_of_one_colour(plane: int, order: str, pixel: bytes) -> None:
    dark, lit = np.zeros((1, 1), np.uint8), np.full((1, 1), 0xFF, np.uint8)
    stack = [lit if k == plane else dark for k in range(24)]
    assert image(stack, "rgb" if order == "rgb" else "grb")[48:52] == b"\x08" + pixel


@settings(max_examples=30, deadline=None)
@given(
    st.integers(1, 24),
    st.integers(1, 6),
    st.sampled_from([8, 136, 1920]),
    st.integers(0, 2**32 - 1),
    st.integers(1, 40),
)
def test_what_is_sent_is_what_is_shown(n: int, rows: int, columns: int, seed: int, width: int) -> None:
    """Blocks of any width, lines that repeat, and noise."""
    random = np.random.default_rng(seed)
    lines = random.integers(0, 2, (n, rows, -(-columns // width)), np.uint8).repeat(width, axis=2)[:, :, :columns]
    stack = list(np.packbits(lines.repeat(2, axis=1), axis=2))
    picture = decode(image(stack, "grb"), columns, 2 * rows)
    for bit, sent in enumerate(stack):
        np.testing.assert_array_equal(picture.plane(bit, "grb"), sent)


def test_noise_is_sent_as_it_is() -> None:
    """24 random planes do not compress: three bytes a pixel, and no more."""
    data = image(planes(24, 16, 64), "rgb")
    assert data[25] == 0
    assert len(data) == 48 + 16 * 64 * 3
    assert decode(data, 64, 16).plane(5, "rgb").tolist() == planes(24, 16, 64)[5].tolist()


def test_a_full_random_picture_is_encoded_in_less_than_it_takes_to_send() -> None:
    """Field reports speak of 15 s of encoding; sending takes 20 s."""
    begun_s = time.perf_counter()
    image(planes(24, 1080, 1920), "rgb")
    assert time.perf_counter() - begun_s < 10


@pytest.mark.parametrize("cut", [1, 5, 50])
def test_a_code_that_breaks_off_is_not_shown(cut: int) -> None:
    data = image(planes(3, 4, 64), "rgb")
    with pytest.raises(BadImage):
        decode(data[:-cut], 64, 4)
