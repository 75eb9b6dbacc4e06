"""Where patterns lie on the mirrors, and which sequences can be played at all."""

from typing import Any

import numpy as np
import pytest

from protocols import PatternSequence, PixelGrid, PlanError


def grid(image_size: int = 2, superpixel: int = 2, columns: int = 16, rows: int = 8) -> PixelGrid:
    return PixelGrid(image_size=image_size, superpixel=superpixel, columns=columns, rows=rows)


def test_the_field_is_centred_on_the_mirrors() -> None:
    """256 of 1024 x 768 mirrors: (768 - 256) / 2 rows above it, (1024 - 256) / 2 columns left of it."""
    field = PixelGrid(image_size=128, superpixel=2)
    assert (field.side_mirrors, field.origin, field.fits) == (256, (256, 384), True)
    assert grid(3, 1).origin == (2, 6), "of an odd rest the smaller half is above and left"


@pytest.mark.parametrize(("columns", "rows", "fits"), [(4, 4, True), (3, 4, False), (4, 3, False), (5, 9, True)])
def test_a_field_fits_if_both_sides_do(columns: int, rows: int, *, fits: bool) -> None:
    assert grid(columns=columns, rows=rows).fits is fits


def test_a_plane_becomes_mirrors_where_the_field_lies_and_is_dark_elsewhere() -> None:
    """A lit upper right pixel of 2 x 2 mirrors: rows 2 and 3, columns 8 and 9 of the 8 x 16."""
    planes = np.packbits(np.array([[[0, 1], [0, 0]], [[0, 0], [0, 0]]], np.uint8), axis=-1)
    sequence = PatternSequence(planes, np.array([0, 0, 1]), grid(), samples=2)
    assert sequence.n_patterns == 2
    assert sequence.sample_plane(0).tolist() == [[0, 1], [0, 0]]
    packed = sequence.mirror_plane(0)
    assert packed.shape == (8, 2)
    lit = np.argwhere(np.unpackbits(packed, axis=-1)).tolist()
    assert lit == [[2, 8], [2, 9], [3, 8], [3, 9]]
    assert not sequence.mirror_plane(1).any()


def test_samples_finer_than_pixels_take_fewer_mirrors() -> None:
    """Four samples a side on four mirrors: each sample is one mirror."""
    bits = np.zeros((2, 4, 4), np.uint8)
    bits[0, 1, 2] = 1
    sequence = PatternSequence(np.packbits(bits, axis=-1), np.array([0, 1]), grid(), samples=4)
    assert np.argwhere(np.unpackbits(sequence.mirror_plane(0), axis=-1)).tolist() == [[3, 8]]


DARK_LAST = np.array([[[0x80], [0x00]], [[0x00], [0x00]]], np.uint8)


@pytest.mark.parametrize(
    ("changed", "saw"),
    [
        ({"planes": DARK_LAST[0]}, r"planes of shape \(2, 1\); expected \(unique, 2, 1\)"),
        ({"planes": DARK_LAST.repeat(2, 2)}, r"planes of shape \(2, 2, 2\)"),
        (
            {"samples": 3, "planes": np.zeros((2, 3, 1), np.uint8)},
            "3 samples on 4 mirrors; expected whole mirrors a sample",
        ),
        ({"grid": grid(rows=3)}, "a field of 4 mirrors a side; expected at most 3"),
        ({"play_order": np.array([1])}, "a play order that is too short"),
        ({"play_order": np.array([0, 2])}, "points outside the planes"),
        ({"play_order": np.array([-1, 1])}, "points outside the planes"),
        ({"play_order": np.array([1, 0])}, "ends on a lit picture; expected a dark guard picture as the last entry"),
    ],
)
def test_a_sequence_that_cannot_be_played_is_refused(changed: dict[str, Any], saw: str) -> None:
    good: dict[str, Any] = {"planes": DARK_LAST, "play_order": np.array([0, 1]), "grid": grid(), "samples": 2}
    PatternSequence(**good)
    with pytest.raises(PlanError, match=saw):
        PatternSequence(**(good | changed))
