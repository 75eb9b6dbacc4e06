"""Pictures by name: what is lit, and what is refused."""

import itertools
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from instrument.patterns import LETTER_WIDTH, PICTURES, letter, picture, picture_of_file
from protocols import InputError


@pytest.mark.parametrize("size", [8, 32])
@pytest.mark.parametrize("name", PICTURES)
def test_a_picture_and_its_complement_are_all_lit_together(name: str, size: int) -> None:
    lit = picture(name, size)
    assert lit.shape == (size, size)
    assert set(np.unique(lit)) <= {0, 1}
    assert (lit + picture(f"not {name}", size) == 1).all()


def test_a_few_by_hand() -> None:
    assert picture("half", 4).tolist() == [[1, 1, 0, 0]] * 4
    assert picture("checker:1", 4)[:2].tolist() == [[1, 0, 1, 0], [0, 1, 0, 1]]
    assert picture("checker:2", 4)[1].tolist() == [1, 1, 0, 0]
    assert picture("checker", 16)[:3, 0].tolist() == [1, 1, 0]
    assert picture("columns:1-3", 4)[2].tolist() == [0, 1, 1, 0]
    assert picture("rows:1-3", 4)[:, 2].tolist() == [0, 1, 1, 0]
    assert np.argwhere(picture("block:1,2,2,1", 4)).tolist() == [[1, 2], [2, 2]]
    assert picture("crosshair", 8)[1].tolist() == [1, 0, 0, 1, 1, 0, 0, 1]
    assert picture("crosshair", 8)[:, 1].tolist() == [1, 0, 0, 1, 1, 0, 0, 1]


def test_a_fringe_has_its_periods_along_x() -> None:
    """Fourier coefficient at the frequency of three periods along x: half of half the light; along y none."""
    spectrum = np.abs(np.fft.fft2(picture("fringe:3", 64))) / 64**2
    assert spectrum[0, 3] == pytest.approx(0.25, abs=0.02)
    assert spectrum[3, 0] < 0.01


def test_the_letter_looks_different_in_each_of_the_eight_ways() -> None:
    drawn = picture("letter", 64)
    ways = [np.rot90(mirrored, turns) for mirrored in (drawn, drawn[:, ::-1]) for turns in range(4)]
    least = min(float(np.mean(np.not_equal(a, b))) for a, b in itertools.combinations(ways, 2))
    assert least > 0.03
    assert letter(20).shape == (20, round(20 * LETTER_WIDTH))
    assert letter(20)[:, 0].all()  # the stem
    assert letter(20)[0].all()  # the upper bar
    assert letter(20)[10].tolist() == [1] * 10 + [0] * 4  # the shorter one in the middle
    assert letter(20)[-1].tolist() == [1] * 4 + [0] * 10


@pytest.mark.parametrize(
    "name",
    [
        *("", "wite", "white:3", "checker:1-2", "columns:3", "columns:3-3", "rows:4-9", "block:0,0,9,1", "block:1,2,3"),
        *("fringe:0", "fringe:5", "columns:-1-3", "white ", "White", "not", "not not white", "columns:8-8"),
    ],
)
def test_what_is_no_picture_is_refused(name: str) -> None:
    with pytest.raises(InputError, match="the picture"):
        picture(name, 8)


def test_a_file_is_fitted_into_the_middle_and_dithered(tmp_path: Path) -> None:
    """A grey of half of the light lights half of the mirrors of its part; above and below nothing is lit."""
    Image.fromarray(np.full((50, 100), 128, np.uint8)).save(tmp_path / "grey.png")
    lit = picture_of_file(tmp_path / "grey.png", 64)
    assert not lit[:16].any()
    assert not lit[48:].any()
    assert lit[16:48].mean() == pytest.approx(128 / 255, abs=0.01)


@pytest.mark.parametrize("content", [b"", b"no picture", b"\x89PNG\r\n\x1a\n" + bytes(30)])
def test_a_file_that_is_no_picture_is_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "a.png").write_bytes(content)
    with pytest.raises(InputError, match=r"a\.png"):
        picture_of_file(tmp_path / "a.png", 64)


def test_a_folder_or_nothing_is_refused(tmp_path: Path) -> None:
    for path in (tmp_path, tmp_path / "gone.png"):
        with pytest.raises(InputError, match="picture"):
            picture_of_file(path, 64)
