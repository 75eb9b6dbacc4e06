"""The pixels that an object can occupy, by hand and as inequalities."""

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from instrument.reconstruction import Region
from protocols import InputError

SIZE = 32
ways = st.lists(st.tuples(st.floats(-12, 12), st.floats(-12, 12)), min_size=1, max_size=6)


def test_the_whole_field_begins_at_its_first_pixel_and_has_no_room_beside_it() -> None:
    assert Region.whole(8) == Region(top=0, left=0, height=8, width=8)
    assert Region.whole(8).room(8) == (0, 0)


def test_the_room_of_a_region_is_what_is_left_to_its_right_and_below_it() -> None:
    """Columns 5 to 11 and rows 2 to 4 of 16: columns 12 to 15 and rows 5 to 15 are left."""
    assert Region(top=2, left=5, height=3, width=7).room(16) == (4, 11)


def test_a_part_is_pasted_at_its_rows_and_columns() -> None:
    image = Region(top=1, left=2, height=1, width=2).paste(np.array([[5.0, 7.0]]), 4)
    assert image.tolist() == [[0, 0, 0, 0], [0, 0, 5, 7], [0, 0, 0, 0], [0, 0, 0, 0]]


def test_a_region_of_four_pixels_is_the_smallest() -> None:
    """Ways of 12 px in a field of 16 leave 4; 12.01 px are widened to 4 as well, and 13 px leave 3."""
    for way_px in (12.0, 12.01):
        assert Region.inside(np.array([[0.0, 0.0], [way_px, 0.0]]), 16).width == 4
    for way in ([13.0, 0.0], [0.0, 13.0], [-13.0, 0.0]):
        with pytest.raises(InputError, match="in a field of 16 px"):
            Region.inside(np.array([[0.0, 0.0], way]), 16)


def test_an_error_about_the_region_tells_the_way_along_each_axis() -> None:
    """From -4 to 9.96 across, that is 14 px; from 0 to 2 down."""
    with pytest.raises(InputError, match=r"displacements of \[14\.0, 2\.0\] px"):
        Region.inside(np.array([[-4.0, 0.0], [9.96, 2.0]]), 16)


@given(way=ways)
def test_every_pixel_of_a_region_stays_at_least_partly_inside_the_field(way: list[tuple[float, float]]) -> None:
    """Frame 0 counts too. One pixel more on any side would be outside altogether somewhere, or lie outside in frame 0."""
    displacement_px = np.array([(0.0, 0.0), *way])
    assume((np.ptp(displacement_px, axis=0) < SIZE - 6).all())
    region = Region.inside(displacement_px, SIZE)
    (least_x, least_y), (most_x, most_y) = displacement_px.min(axis=0), displacement_px.max(axis=0)
    for first, length, least, most in (
        (region.left, region.width, least_x, most_x),
        (region.top, region.height, least_y, most_y),
    ):
        assert first + 1 + least >= 0
        assert first + length - 1 + most <= SIZE
        assert first + least <= 0
        assert first + length + most >= SIZE
