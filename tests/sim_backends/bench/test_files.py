"""Objects and trajectories from files, and how they are refused."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from protocols import InputError
from sim_backends.bench.files import load_object, load_trajectory
from sim_backends.bench.image import AreaImage


def load(folder: Path, name: str, size: int = 8) -> AreaImage:
    return load_object(name, folder, key="object", image_size=size, height_px=None, centre_px=None)


def refusal(folder: Path, name: str) -> str:
    with pytest.raises(InputError) as caught:
        load(folder, name)
    return str(caught.value)


def test_a_png_is_transmission_from_black_to_white(tmp_path: Path) -> None:
    Image.fromarray(np.array([[0, 51], [102, 255]], np.uint8)).save(tmp_path / "scene.png")
    image = load(tmp_path, "scene.png")
    assert image.cells.tolist() == [[0.0, 0.2], [0.4, 1.0]]
    assert (image.cell_px, image.left_px, image.top_px) == (4.0, 0.0, 0.0)


def test_sixteen_bit_one_bit_and_colour_pictures_are_read_too(tmp_path: Path) -> None:
    Image.fromarray(np.array([[0, 13107], [39321, 65535]], np.uint16)).save(tmp_path / "deep.png")
    assert load(tmp_path, "deep.png").cells.tolist() == [[0.0, 0.2], [0.6, 1.0]]
    Image.fromarray(np.array([[False, True]])).save(tmp_path / "bits.png")
    assert load(tmp_path, "bits.png").cells.tolist() == [[0.0, 1.0]]
    Image.fromarray(np.full((2, 2, 3), 255, np.uint8)).save(tmp_path / "colour.png")
    assert load(tmp_path, "colour.png").cells.tolist() == [[1.0, 1.0], [1.0, 1.0]]


def test_where_a_picture_is_transparent_there_is_no_object(tmp_path: Path) -> None:
    white_on_nothing = np.full((1, 3, 4), 255, np.uint8)
    white_on_nothing[0, :, 3] = [0, 51, 255]
    Image.fromarray(white_on_nothing).save(tmp_path / "cut-out.png")
    assert load(tmp_path, "cut-out.png").cells.tolist() == [[0.0, 0.2, 1.0]]
    Image.fromarray(np.array([[90, 255]], np.uint8)).save(tmp_path / "keyed.png", transparency=90)
    assert load(tmp_path, "keyed.png").cells.tolist() == [[0.0, 1.0]]


def test_the_longer_side_of_a_picture_fills_the_image_and_the_rest_is_dark(tmp_path: Path) -> None:
    np.save(tmp_path / "wide.npy", np.ones((2, 4)))
    field = load(tmp_path, "wide.npy").on_grid(0.0, 0.0, 8, 1.0)
    assert field[2:6].all()
    assert field.sum() == 32.0


def test_a_picture_can_be_made_smaller_and_put_elsewhere(tmp_path: Path) -> None:
    np.save(tmp_path / "tall.npy", np.ones((4, 2)))
    image = load_object("tall.npy", tmp_path, key="object", image_size=16, height_px=6.0, centre_px=(4.0, 5.0))
    assert (image.cell_px, image.left_px, image.top_px) == (1.5, 2.5, 2.0)
    field = image.on_grid(0.0, 0.0, 16, 1.0)
    assert field.sum() == pytest.approx(18.0)
    assert field[2:8, 3:5].min() == 1.0


def test_a_built_in_stands_on_whole_pixels_in_the_upper_left_quarter(tmp_path: Path) -> None:
    image = load(tmp_path, "letter-B", size=128)
    assert (image.left_px, image.top_px) == (18, 14)
    assert image.cells.shape == (36, 28)


def test_the_centre_of_a_built_in_can_be_chosen(tmp_path: Path) -> None:
    image = load_object("square", tmp_path, key="object", image_size=32, height_px=4.0, centre_px=(10.5, 20.0))
    assert (image.left_px, image.top_px) == (8.5, 18.0)


def test_a_built_in_too_small_to_be_drawn_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="'letter-I': nothing in it lets light through"):
        load_object("letter-I", tmp_path, key="object", image_size=8, height_px=2.0, centre_px=None)


def test_a_name_that_is_neither_built_in_nor_a_file_lists_what_there_is(tmp_path: Path) -> None:
    message = refusal(tmp_path, "leter-B")
    assert "[scene] object = 'leter-B'" in message
    assert "letter-B" in message
    assert "plane" in message


@pytest.mark.parametrize("name", ["notes.png", "notes.npy", "notes.txt"])
def test_a_file_that_is_not_an_image_is_named(tmp_path: Path, name: str) -> None:
    (tmp_path / name).write_text("not a picture")
    assert str(tmp_path / name) in refusal(tmp_path, name)


def test_a_truncated_picture_is_named(tmp_path: Path) -> None:
    Image.fromarray(np.arange(256 * 64, dtype=np.uint32).astype(np.uint8).reshape(128, 128)).save(tmp_path / "cut.png")
    whole = (tmp_path / "cut.png").read_bytes()
    (tmp_path / "cut.png").write_bytes(whole[: len(whole) // 2])
    assert "cut.png" in refusal(tmp_path, "cut.png")


@pytest.mark.parametrize(
    ("cells", "saw"),
    [
        (np.full((2, 2), 1.5), "transmission from 1.5 to 1.5"),
        (np.array([[0.5, -0.25]]), "transmission from -0.25 to 0.5"),
        (np.array([[0.5, np.nan]]), "nan"),
        (np.ones((2, 2, 3)), "shape (2, 2, 3)"),
        (np.ones(4), "shape (4,)"),
        (np.zeros((2, 2)), "nothing in it lets light through"),
        (np.array([["a", "b"]]), "an array of <U1"),
        (np.array([["0.5"]]), "an array of <U3"),
        (np.array([[0.5 + 0.5j]]), "an array of complex128"),
    ],
)
def test_an_array_that_is_no_transmission_is_refused(tmp_path: Path, cells: np.ndarray, saw: str) -> None:
    np.save(tmp_path / "cells.npy", cells)
    message = refusal(tmp_path, "cells.npy")
    assert saw in message
    assert "cells.npy" in message


def trajectory(folder: Path, text: str) -> Path:
    path = folder / "path.csv"
    path.write_text(text)
    return path


def test_a_trajectory_is_times_and_displacements(tmp_path: Path) -> None:
    time_s, at_px = load_trajectory(trajectory(tmp_path, "t_s, x_px, y_px\n0,1,2\n\n0.5,3,-4\n"))
    assert time_s.tolist() == [0.0, 0.5]
    assert at_px.tolist() == [[1.0, 2.0], [3.0, -4.0]]


@pytest.mark.parametrize(
    ("text", "where", "saw"),
    [
        ("", "line 1", "nothing"),
        ("0,1,2\n", "line 1", "'0,1,2'"),
        ("t_s,x_mm,y_mm\n0,1,2\n", "line 1", "'t_s,x_mm,y_mm'"),
        ("t_s,x_px,y_px\n", "path.csv", "no rows"),
        ("t_s,x_px,y_px\n0,1,2\n1,,2\n", "line 3", "'1,,2'"),
        ("t_s,x_px,y_px\n0,1,2\n1,nan,2\n", "line 3", "'1,nan,2'"),
        ("t_s,x_px,y_px\n0,one,2\n", "line 2", "'0,one,2'"),
        ("t_s,x_px,y_px\n0,1\n", "line 2", "'0,1'"),
        ("t_s,x_px,y_px\n0,1,2\n1,1,2\n1,1,2\n", "line 4", "t_s = 1 after 1"),
        ("t_s,x_px,y_px\n0,1,2\n2,1,2\n1,1,2\n", "line 4", "t_s = 1 after 2"),
        ("t_s,x_px,y_px\n0,0,0\n.1,1,0\n.2,2,0\n\n1.3,3,0\n1.4,3,0\n", "line 6", "a gap in time of 1.1 s"),
    ],
)
def test_a_trajectory_that_cannot_be_used_is_refused_with_its_line(
    tmp_path: Path, text: str, where: str, saw: str
) -> None:
    with pytest.raises(InputError) as caught:
        load_trajectory(trajectory(tmp_path, text))
    assert where in str(caught.value)
    assert saw in str(caught.value)
    assert "path.csv" in str(caught.value)


def test_a_step_of_ten_usual_steps_is_no_gap_yet(tmp_path: Path) -> None:
    time_s, _ = load_trajectory(trajectory(tmp_path, "t_s,x_px,y_px\n0,0,0\n1,0,0\n2,0,0\n12,0,0\n"))
    assert time_s[-1] == 12.0


def test_a_trajectory_that_is_not_there_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"nowhere\.csv"):
        load_trajectory(tmp_path / "nowhere.csv")
