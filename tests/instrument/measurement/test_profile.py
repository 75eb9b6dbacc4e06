"""Brightness of the field: by hand, from a picture, and where the numbers come from."""

from pathlib import Path

import numpy as np
import pytest

from instrument.config import ConfigError, LightTable, Stated, StatedProfile, load_bench
from instrument.measurement import LightModel, Parameter, Profile
from tests.support.benches import bench_toml


def test_two_points_an_axis_are_a_straight_line_from_edge_to_edge() -> None:
    """Middles of four pixels lie at 1/8, 3/8, 5/8 and 7/8 of the way from 1 to 0."""
    down = Profile(values=((1.0, 1.0), (0.0, 0.0))).over(4)
    np.testing.assert_allclose(down, np.array([7, 5, 3, 1])[:, None] / 8 * np.ones(4), atol=1e-12)
    across = Profile(values=((0.0, 1.0), (0.0, 1.0))).over(2)
    np.testing.assert_allclose(across, [[0.25, 0.75]] * 2, atol=1e-12)


def test_three_points_are_a_parabola() -> None:
    """1 - x^2 at 0.5 px of 2 px, x from -1 to 1: x = -1/2 and 1/2."""
    found = Profile(values=((0.0, 1.0, 0.0),) * 2).over(2)
    np.testing.assert_allclose(found, np.full((2, 2), 0.75), atol=1e-12)


def test_a_picture_becomes_the_profile_that_it_shows() -> None:
    x, y = np.meshgrid(*[(np.arange(32) + 0.5) / 16 - 1] * 2)
    picture = 1 - 0.2 * x**2 - 0.1 * y + 0.05 * x * y**2
    profile = Profile.of(picture, points=5, sigma=0.01)
    np.testing.assert_allclose(profile.over(32), picture, atol=1e-9)
    assert profile.values[0][4] == pytest.approx(1 - 0.2 + 0.1 + 0.05)  # x = 1, y = -1
    assert (profile.source, profile.sigma, len(profile.values)) == ("calibrated", 0.01, 5)


def test_a_table_says_who_states_its_numbers(tmp_path: Path) -> None:
    lines = [
        "[light]",
        'leak = { value = 0.04, sigma = 0.002, source = "calibrated" }',
        "edge_loss = { value = 0.02 }",
        'profile = { values = [[0.5, 1], [1.0, 1.0]], sigma = 0.01, source = "calibrated" }',
    ]
    table = load_bench(bench_toml(tmp_path, "\n".join(lines))).light
    light = LightModel.of(table)
    assert light.leak == Parameter(value=0.04, sigma=0.002, source="calibrated")
    assert not light.leak.free
    assert light.edge_loss == Parameter(value=0.02, source="given")
    assert light.profile == Profile(values=((0.5, 1.0), (1.0, 1.0)), sigma=0.01, source="calibrated")
    assert LightTable.model_validate(table.model_dump(mode="json")) == table


def test_bare_numbers_are_given() -> None:
    light = LightModel.of(LightTable(leak=0.1, profile=((1.0, 0.5), (1.0, 0.5))))
    assert light.profile == Profile(values=((1.0, 0.5), (1.0, 0.5)), source="given")
    assert LightModel.of(LightTable(leak=Stated(value=0.1))) == LightModel.of(LightTable(leak=0.1))
    stated = StatedProfile(values=((1.0, 0.5), (1.0, 0.5)))
    assert LightModel.of(LightTable(profile=stated)).profile == light.profile


@pytest.mark.parametrize(
    "line",
    [
        "profile = [[1.0, 1.0], [1.0]]",
        "profile = [[1.0, 1.0]]",
        "profile = [[1.0], [1.0]]",
        "profile = [[1.0, 0.0], [1.0, 1.0]]",
        "profile = [[1.0, 11.0], [1.0, 1.0]]",
        "leak = { value = 0.41 }",
        'leak = { value = 0.1, source = "fitted" }',
        "edge_loss = { value = 0.1, sigma = -1 }",
    ],
)
def test_what_cannot_be_is_refused(tmp_path: Path, line: str) -> None:
    path = bench_toml(tmp_path, f"[light]\n{line}")
    with pytest.raises(ConfigError) as caught:
        load_bench(path)
    assert "light." in str(caught.value)


def test_blocks_of_a_falling_light_give_its_surface_and_bad_blocks_little() -> None:
    """1 - 0.35 r^2 / 2 in the corners' r: 0.65 there. A block's mean of r^2 lies 1 / 96 above r^2 in its middle, for 8 blocks."""
    middle = (np.arange(8) + 0.5) / 4 - 1
    squares = middle[:, None] ** 2 + middle**2 + 2 / (3 * 8**2)
    blocks = 1 - 0.35 * squares / 2
    sigma = np.full((8, 8), 0.01)
    profile = Profile.of_blocks(blocks, sigma)
    assert np.array(profile.values) == pytest.approx(
        np.array([[0.65, 0.825, 0.65], [0.825, 1, 0.825], [0.65, 0.825, 0.65]])
    )
    assert profile.source == "calibrated"
    assert profile.sigma is not None
    assert 0.005 < profile.sigma < 0.01, "less than a block's, as six numbers are found of 64"
    blocks[3, 3], sigma[3, 3] = 5.0, 1e3
    assert np.allclose(Profile.of_blocks(blocks, sigma).values, profile.values, atol=1e-4)
