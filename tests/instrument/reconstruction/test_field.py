"""The field as the light sees it: small ones written out, larger ones mirror by mirror."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from instrument.patterns import hadamard_signs
from instrument.reconstruction import Field, hadamard_values
from instrument.reconstruction.field import acting_walsh, padded_walsh, walsh_steps
from protocols import Bytes, Floats


def _one(*rows: list[int]) -> Bytes:
    return np.array([rows], np.uint8)


def test_rows_of_four_pixels_by_hand() -> None:
    """The outside is as the other sign: the ends of every row border it. Entries are 1 minus 0.1 a side."""
    assert acting_walsh(Field(4)).tolist() == [[1, 1, 1, 1], [1, 1, -1, -1], [1, -1, -1, 1], [1, -1, 1, -1]]
    np.testing.assert_allclose(
        acting_walsh(Field(4, edge_loss=0.1)),
        [[0.9, 1, 1, 0.9], [0.9, 0.9, -0.9, -0.9], [0.8, -0.9, -0.9, 0.8], [0.8, -0.8, 0.8, -0.8]],
    )


def test_on_a_grid_of_two_each_entry_is_two_halves() -> None:
    assert acting_walsh(Field(2, 2)).tolist() == [[0.5, 0.5, 0.5, 0.5], [0.5, 0.5, -0.5, -0.5]]
    assert Field(2, 2).pixels == 4
    np.testing.assert_allclose(acting_walsh(Field(2, 2, 0.2))[1], [0.3, 0.3, -0.3, -0.3])
    assert not acting_walsh(Field(2, 2)).flags.writeable


def test_padding_and_steps_by_hand() -> None:
    assert padded_walsh(Field(2)).tolist() == [[0, 0, 0, 1, 1, 0, 0, 0], [0, 0, 0, 1, -1, 0, 0, 0]]
    assert walsh_steps(Field(2)).toarray().tolist() == [[1, 0, -1], [1, -2, 1]]
    assert walsh_steps(Field(2, 2)).toarray().tolist() == [[0.5, 0, 0, 0, -0.5], [0.5, 0, -1, 0, 0.5]]


def test_a_checkerboard_of_four_pixels_borders_the_dark_on_all_sides() -> None:
    assert Field(2).bordering(_one([1, 0], [0, 1])).tolist() == [[[4, 0], [0, 4]]]
    assert Field(2).bordering(_one([1, 1], [0, 0])).tolist() == [[[3, 3], [0, 0]]]
    assert Field(2, edge_loss=0.1).acting(_one([1, 1], [0, 0])) == pytest.approx(np.array([[[0.7, 0.7], [0, 0]]]))
    assert Field(2).acting(_one([1, 1], [0, 0])).tolist() == [[[1, 1], [0, 0]]]


def test_samples_of_half_a_pixel_lose_twice_the_share() -> None:
    """A lit quarter of one pixel: four sides of half a length, over a quarter of the light: 4 x 2 / 4 = 2."""
    pattern = _one([1, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0])
    assert Field(2).acting(pattern).tolist() == [[[0.25, 0], [0, 0]]]
    assert Field(2).bordering(pattern).tolist() == [[[2, 0], [0, 0]]]


def test_the_light_of_a_pixel_is_shared_by_the_pixels_of_a_finer_image() -> None:
    pattern = _one([1, 0], [0, 0])
    found = Field(2, 2).acting(pattern)
    assert found.tolist() == [[[0.25, 0.25, 0, 0], [0.25, 0.25, 0, 0], [0, 0, 0, 0], [0, 0, 0, 0]]]
    samples = np.random.default_rng(0).integers(0, 2, (3, 12, 12)).astype(np.uint8)
    fine, coarse = Field(4, 2, 0.05).acting(samples), Field(4, 1, 0.05).acting(samples)
    np.testing.assert_allclose(fine.reshape(3, 4, 2, 4, 2).sum(axis=(2, 4)), coarse, atol=1e-6)


def _brute_force(field: Field, image: Floats, pair: tuple[int, int]) -> float:
    """I_H+ - I_H- of an image, its pattern pixels summed, with the light of H+ and H- as each of them acts, pixel by pixel."""
    signs = hadamard_signs(field.size, np.array([pair])).astype(np.float64)[0]
    of_pixel = image.reshape(field.size, field.grid, field.size, field.grid).mean(axis=(1, 3))
    value = 0.0
    for sign in (1, -1):
        lit = (1 + sign * signs) / 2
        around = np.pad(lit, 1)
        dark = 4 - around[:-2, 1:-1] - around[2:, 1:-1] - around[1:-1, :-2] - around[1:-1, 2:]
        value += sign * float((lit * (1 - field.edge_loss * dark) * of_pixel).sum())
    return value


@given(
    seed=st.integers(0, 1000),
    down=st.integers(0, 7),
    across=st.integers(0, 7),
    grid=st.integers(1, 3),
    loss=st.sampled_from([0.0, 0.02]),
)
def test_values_of_an_image_at_rest_are_those_of_all_pixels_together(
    seed: int, down: int, across: int, grid: int, loss: float
) -> None:
    """But for the square of the loss, at most (2 x 0.02)^2 of a pixel's light, where rows and columns both lose some."""
    field = Field(8, grid, loss)
    image = np.random.default_rng(seed).random((8 * grid, 8 * grid))
    found = hadamard_values(field, image, np.array([[down, across]]))[0]
    light = float(image.sum()) / grid**2
    assert found == pytest.approx(_brute_force(field, image, (down, across)), abs=1e-9 + (2 * loss) ** 2 * light)
