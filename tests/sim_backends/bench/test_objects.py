"""Built-in objects."""

import numpy as np
import pytest

from sim_backends.bench.objects import BUILT_INS


def test_the_letter_b_fills_about_five_percent_of_the_image() -> None:
    letter = BUILT_INS["letter-B"](36)
    assert letter.cells.shape == (36, 28)  # 2.5 mm x 3.2 mm has the same proportions
    assert letter.cells.sum() / 128**2 == pytest.approx(0.05, abs=0.002)
    assert set(np.unique(letter.cells)) == {0.0, 1.0}


def test_the_letter_b_has_two_holes_and_a_straight_back() -> None:
    letter = BUILT_INS["letter-B"](36).cells
    assert letter[:, 0].all()
    middle = letter[:, 13]
    assert np.count_nonzero(np.diff(middle)) == 4  # two dark stretches down the middle
    assert not letter[0, -1]
    assert not letter[-1, -1]


@pytest.mark.parametrize("name", sorted(set(BUILT_INS) - {"bars", "nothing"}))
@pytest.mark.parametrize("height_px", [36, 46, 9.4])
def test_a_built_in_is_as_high_as_asked_and_touches_its_box(name: str, height_px: float) -> None:
    cells = BUILT_INS[name](height_px).cells
    assert len(cells) == round(height_px)
    assert cells.any(axis=1).all()
    assert cells.any(axis=0).sum() >= cells.shape[1] - 1
    assert 0 <= cells.min() <= cells.max() == 1


def test_a_disc_and_a_ring_have_the_areas_of_their_circles() -> None:
    assert BUILT_INS["disc"](100).cells.sum() == pytest.approx(np.pi * 50**2, rel=0.005)
    assert BUILT_INS["ring"](100).cells.sum() == pytest.approx(np.pi * (50**2 - 30**2), rel=0.01)


def test_bars_are_groups_of_three_with_widths_of_4_3_2_and_1_5_px() -> None:
    bars = BUILT_INS["bars"](36)
    assert bars.cell_px == 0.5
    for row, width_cells in ((0, 8), (48, 6), (86, 4)):
        upright = bars.cells[row, : 5 * width_cells]
        assert upright.tolist() == [float(cell // width_cells % 2 == 0) for cell in range(5 * width_cells)]
    assert bars.cells[86, 48:63].tolist() == [float(cell // 3 % 2 == 0) for cell in range(15)]
    for width_cells, top, left in ((8, 0, 48), (6, 48, 36), (4, 86, 24), (3, 86, 66)):
        lying = bars.cells[top : top + 5 * width_cells, left]
        assert lying.tolist() == [float(cell // width_cells % 2 == 0) for cell in range(5 * width_cells)]


def test_the_aeroplane_is_grey_and_symmetric() -> None:
    plane = BUILT_INS["plane"](90).cells
    assert set(np.unique(plane)) == {0.0, 0.4, 0.6, 1.0}
    assert np.mean(plane != plane[:, ::-1]) < 0.02
