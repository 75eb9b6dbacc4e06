"""The binary frames, byte by byte."""

import struct

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from instrument.web.frames import IMAGE, PATH, frame, image_body, path_body


def test_the_head_is_32_bytes_in_the_order_that_the_page_reads() -> None:
    sent = frame(IMAGE, 258, b"rest", skipped=3, sent_s=1.5, made_s=-2.0)
    assert sent[:16] == b"KNPX" + bytes([2, 0, 1, 0, 2, 1, 0, 0, 3, 0, 0, 0])
    assert sent[16:32] == struct.pack("<dd", 1.5, -2.0)
    assert sent[32:] == b"rest"


def test_an_image_is_columns_rows_frames_white_and_a_byte_a_pixel() -> None:
    body = image_body(np.array([[0.0, 1.0, 2.0], [-1.0, 4.0, 4.0]]), frames=7)
    assert body == struct.pack("<HHIf", 3, 2, 7, 4.0) + bytes([0, 64, 128, 0, 255, 255])


def test_a_few_wild_pixels_do_not_darken_an_image_and_a_small_object_is_none() -> None:
    """128 x 128: 20 pixels are less than 2 of 1000, and the white is a quarter of the brightest at least."""
    image = np.ones((128, 128))
    image.flat[:20] = 2.0
    assert struct.unpack_from("<f", image_body(image, 1), 8)[0] == 1.0
    alone = np.zeros((128, 128))
    alone.flat[:20] = 8.0
    assert struct.unpack_from("<f", image_body(alone, 1), 8)[0] == 2.0


@pytest.mark.parametrize("image", [np.zeros((4, 4)), np.full((4, 4), -1.0), np.full((4, 4), np.nan)])
def test_an_image_without_light_is_black(image: np.ndarray) -> None:
    assert image_body(image, 1)[12:] == bytes(16)


def test_a_path_is_the_index_of_its_first_point_and_five_floats_a_point() -> None:
    body = path_body(5, np.array([[0.25, 1.0, -2.0, 0.125, 0.5], [0.5, 3.0, 4.0, 0.25, 1.0]]))
    assert body == struct.pack("<I10f", 5, 0.25, 1.0, -2.0, 0.125, 0.5, 0.5, 3.0, 4.0, 0.25, 1.0)
    assert len(frame(PATH, 1, body, skipped=0, sent_s=0.0, made_s=0.0)) == 32 + 4 + 40


@given(st.integers(0, 2**40), st.integers(0, 2**40))
def test_numbers_of_a_run_without_end_fit(sequence: int, skipped: int) -> None:
    sent = frame(IMAGE, sequence, b"", skipped=skipped, sent_s=0.0, made_s=0.0)
    assert struct.unpack_from("<II", sent, 8) == (sequence % 2**32, skipped % 2**32)
