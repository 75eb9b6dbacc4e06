"""Where the object is: between the rows of a file, and on a stage whose motion is told piece by piece."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocols import Floats
from sim_backends.bench.motion import Position, StageMotion, Trajectory


def _ahead(velocity_mm_s: float, at_mm: float = 0.0) -> Position:
    def position_mm(clock_s: Floats) -> Floats:
        return at_mm + velocity_mm_s * clock_s

    return position_mm


def _shift(motion: StageMotion, start_s: float, *time_s: float) -> list[list[float]]:
    shift_px: list[list[float]] = motion.at(start_s, np.array(time_s)).tolist()
    return shift_px


def test_between_rows_a_trajectory_is_a_straight_line_and_beyond_them_it_is_held() -> None:
    """From (1, -2) at 1 s to (5, 6) at 3 s: half-way at 2 s, a quarter at 1.5 s."""
    way = Trajectory(np.array([1.0, 3.0]), np.array([[1.0, -2.0], [5.0, 6.0]]))
    found = way.at(77.0, np.array([0.0, 1.0, 1.5, 2.0, 3.0, 9.0]))
    assert found.tolist() == [[1, -2], [1, -2], [2, 0], [3, 2], [5, 6], [5, 6]]


def test_a_stage_that_nobody_has_told_of_stands_at_zero() -> None:
    motion = StageMotion([], px_per_mm=2.0, axis_angle_deg=0.0, origin_mm=1.5)
    assert motion.position_mm(np.array([0.0, 9.0])).tolist() == [0.0, 0.0]
    assert _shift(motion, 0.0, 5.0) == [[-3.0, 0.0]]


@pytest.mark.parametrize(
    ("angle_deg", "shift_px"),
    [(0.0, [6.0, 0.0]), (90.0, [0.0, 6.0]), (180.0, [-6.0, 0.0]), (-90.0, [0.0, -6.0]), (30.0, [5.196152, 3.0])],
)
def test_the_axis_is_turned_from_right_to_down(angle_deg: float, shift_px: list[float]) -> None:
    """3 mm beyond the origin at 2 px/mm; 6 cos 30 = 5.196152 to the right, 6 sin 30 = 3 down."""
    motion = StageMotion([(0.0, _ahead(1.0))], px_per_mm=2.0, axis_angle_deg=angle_deg, origin_mm=4.0)
    assert _shift(motion, 5.0, 2.0) == [shift_px]


def test_what_was_said_before_a_change_stays_true_for_the_time_before_it() -> None:
    """0 mm until 1 s, then 10 mm; from 2 s on 3 mm/s from 20 mm. A change holds from its own moment on."""
    carried = [(1.0, _ahead(0.0, 10.0)), (2.0, _ahead(3.0, 14.0))]
    motion = StageMotion(carried, 1.0, 0.0, 0.0)
    found = motion.position_mm(np.array([0.5, 1.0, 1.999, 2.0, 3.0, 0.0]))
    assert found.tolist() == [0.0, 10.0, 10.0, 20.0, 23.0, 0.0]


def test_times_count_from_the_first_edge_on_the_clock() -> None:
    """2 mm/s: a run that begins at 5 s has the object at 10 mm, and 0.5 s later at 11."""
    motion = StageMotion([(0.0, _ahead(2.0))], 1.0, 0.0, 10.0)
    assert _shift(motion, 5.0, 0.0, 0.5) == [[0.0, 0.0], [1.0, 0.0]]


def test_displacements_are_whole_millionths_of_a_pixel() -> None:
    """1/3 mm at 1 px/mm; the last bits of a clock reading make no difference."""
    motion = StageMotion([(0.0, _ahead(1.0))], 1.0, 0.0, 0.0)
    assert _shift(motion, 0.0, 1 / 3, np.nextafter(1 / 3, 1.0)) == [[0.333333, 0.0], [0.333333, 0.0]]


@given(angle_deg=st.floats(-720, 720), way_mm=st.floats(-400, 400), px_per_mm=st.floats(0.1, 100))
def test_the_way_in_pixels_is_as_long_as_that_in_millimetres(angle_deg: float, way_mm: float, px_per_mm: float) -> None:
    """Within half of a millionth of a pixel along each axis, whatever the direction; a half turn reverses it."""
    motion = StageMotion([(0.0, _ahead(0.0, way_mm))], px_per_mm, angle_deg, 0.0)
    turned = StageMotion([(0.0, _ahead(0.0, way_mm))], px_per_mm, angle_deg + 180, 0.0)
    (there,), (back,) = motion.at(0.0, np.zeros(1)), turned.at(0.0, np.zeros(1))
    assert np.hypot(*there) == pytest.approx(abs(way_mm) * px_per_mm, abs=1e-6)
    np.testing.assert_allclose(there, -back, atol=1.1e-6)
