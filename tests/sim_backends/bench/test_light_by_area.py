"""Light as the area of overlap: cells, samples, edges of mirrors, lamps and photons, by formulas of one line."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from protocols import Bytes, Floats, PixelGrid
from sim_backends.bench.dead_time import non_paralyzable as count_photons
from sim_backends.bench.image import AreaImage, Window
from sim_backends.bench.lamp import Lamp
from sim_backends.bench.light import LightPath, Optics
from sim_backends.bench.noise import measure
from sim_backends.bench.noise_settings import PhotonNoise, PixelNoise
from sim_backends.bench.planes import field_mirrors, superpixels
from sim_backends.bench.pose import ChangingImage
from tests.sim_backends.projector import SIZE, all_on, bench_with, pixel, save, values

GRID = PixelGrid(image_size=4, superpixel=2, columns=24, rows=16)
"""Eight mirrors a side, from column 8 and row 4 on."""


def _overlap(first: float, length: float, samples: int, sample_px: float) -> Floats:
    """Length that [first, first + length] has in common with each sample."""
    begin = np.arange(samples) * sample_px
    shared: Floats = np.maximum(np.minimum(begin + sample_px, first + length) - np.maximum(begin, first), 0.0)
    return shared


places = st.tuples(st.floats(-8, 8), st.floats(-8, 8))


@given(at_px=places, corner_px=places, cell_px=st.floats(0.3, 5), sample_px=st.sampled_from([0.5, 1.0, 2.0]))
def test_one_cell_lights_each_sample_by_the_area_that_they_share(
    at_px: tuple[float, float], corner_px: tuple[float, float], cell_px: float, sample_px: float
) -> None:
    (dx, dy), (left, top), samples = at_px, corner_px, round(8 / sample_px)
    seen = AreaImage(np.array([[0.7]]), cell_px, left, top).on_grid(dx, dy, samples, sample_px)
    down, across = (_overlap(at, cell_px, samples, sample_px) for at in (top + dy, left + dx))
    np.testing.assert_allclose(seen, 0.7 * np.outer(down, across), atol=1e-9)


@given(dx=st.floats(-9, 9), dy=st.floats(-9, 9), seed=st.integers(0, 1000))
def test_a_picture_without_its_dark_borders_gives_the_same_light(dx: float, dy: float, seed: int) -> None:
    rng = np.random.default_rng(seed)
    cells = np.pad(rng.random((2, 3)), ((1, 2), (3, 0)))
    picture = AreaImage(cells, 0.8, 2.0, 1.0)
    cut = picture.without_dark_borders()
    assert cut.cells.shape == (2, 3)
    assert [cut.left_px, cut.top_px] == pytest.approx([2.0 + 3 * 0.8, 1.0 + 0.8])
    np.testing.assert_allclose(cut.on_grid(dx, dy, 8, 1.0), picture.on_grid(dx, dy, 8, 1.0), atol=1e-12)


def test_of_a_dark_picture_one_cell_is_left_where_it_began() -> None:
    cut = AreaImage(np.zeros((3, 4)), 0.5, 2.0, 1.0).without_dark_borders()
    assert (cut.cells.tolist(), cut.left_px, cut.top_px) == ([[0.0]], 2.0, 1.0)


@pytest.mark.parametrize(
    ("window", "empty"),
    [(Window(2, 3, 2, 3), False), (Window(2, 2, 2, 3), True), (Window(2, 3, 3, 3), True), (Window(3, 2, 2, 3), True)],
)
def test_a_window_is_empty_without_a_row_or_without_a_column(window: Window, *, empty: bool) -> None:
    assert window.empty is empty


# Mirrors


def _packed(*lit: tuple[int, int]) -> Bytes:
    """A plane of 16 x 24 mirrors, packed, with some lit."""
    plane = np.zeros((16, 24), np.uint8)
    for row, column in lit:
        plane[row, column] = 1
    return np.packbits(plane, axis=1)


def test_the_field_of_mirrors_begins_where_the_grid_says() -> None:
    """Rows 4 to 11 and columns 8 to 15 of 16 x 24: mirrors outside are not seen."""
    field = field_mirrors(_packed((4, 8), (11, 15), (3, 8), (12, 15), (4, 7), (11, 16)), GRID)
    assert field.shape == (8, 8)
    assert np.argwhere(field).tolist() == [[0, 0], [7, 7]]


def test_superpixels_are_seen_only_where_all_of_their_mirrors_agree() -> None:
    """Superpixel (0, 3) has the mirrors of rows 4 and 5, columns 14 and 15."""
    whole = [(4, 14), (4, 15), (5, 14), (5, 15)]
    found = superpixels(_packed(*whole), GRID)
    assert found is not None
    assert np.argwhere(found).tolist() == [[0, 3]]
    for missing in whole:
        assert superpixels(_packed(*(mirror for mirror in whole if mirror != missing)), GRID) is None


@pytest.mark.parametrize("lit", [[(4, 8), (4, 9), (5, 8), (5, 9)], [(4, 8), (7, 12), (11, 15)]])
def test_the_lit_area_counts_mirrors_by_their_quarter_of_a_pixel(lit: list[tuple[int, int]]) -> None:
    """Four mirrors are one pixel, three are 3/4, on superpixels or not; an even scene of 0.5 gives half of it as light."""
    scene = AreaImage(np.full((1, 1), 0.5), 4.0, 0.0, 0.0)
    path = LightPath(ChangingImage(scene), Optics(), GRID, lambda _index: _packed(*lit))
    seen = path.of(np.array([0]), np.zeros((1, 2)), np.zeros(1))
    assert seen.lit_px.tolist() == [len(lit) / 4]
    assert seen.light.tolist() == [pytest.approx(0.5 * len(lit) / 4)]


def test_planes_are_fetched_once_and_each_picture_keeps_its_own() -> None:
    """Planes 0 and 1, shown three times and twice, with 1 and 2 pixels lit at the far ends of the field."""
    planes = [_packed((4, 8), (4, 9), (5, 8), (5, 9)), _packed(*[(r, c) for r in (10, 11) for c in (12, 13, 14, 15)])]
    fetched: list[int] = []

    def mirrors(index: int) -> Bytes:
        fetched.append(index)
        return planes[index]

    path = LightPath(ChangingImage(AreaImage(np.ones((1, 1)), 4.0, 0.0, 0.0)), Optics(), GRID, mirrors)
    order = np.array([1, 0, 0, 1, 0])
    assert path.of(order, np.zeros((5, 2)), np.zeros(5)).light.tolist() == [2, 1, 1, 2, 1]
    assert fetched == [1, 0]


def test_an_object_at_rest_gives_the_light_of_each_picture_alone() -> None:
    """To the bit, whether a plane comes once or often, and with an object that moves on before the last picture."""
    rng = np.random.default_rng(4)
    packed = [_packed(*[(4 + r, 8 + c) for r in range(8) for c in range(8) if rng.random() < 0.5]) for _ in range(3)]
    path = LightPath(ChangingImage(AreaImage(rng.random((4, 4)), 1.0, 0.0, 0.0)), Optics(), GRID, packed.__getitem__)
    order, resting = np.array([2, 0, 2, 1, 0]), np.tile([0.3, -0.7], (5, 1))
    moved = resting + np.array([[0.0], [0.0], [0.0], [0.0], [0.5]])
    for at_px in (resting, moved):
        alone = [path.of(order[k : k + 1], at_px[k : k + 1], np.zeros(1)).light.item() for k in range(5)]
        assert path.of(order, at_px, np.zeros(5)).light.tolist() == alone
        assert len(set(alone)) == (3 if at_px is resting else 4)


def test_a_lamp_that_fades_is_dark_and_not_darker_than_dark() -> None:
    """Level 3 and -0.25 a second: 3 at 0 s, 1.5 at 2 s, nothing at 4 s and after."""
    scene = AreaImage(np.ones((1, 1)), 1.0, 0.0, 0.0)
    lit = _packed((4, 8), (4, 9), (5, 8), (5, 9))
    path = LightPath(ChangingImage(scene), Optics(Lamp(level=3.0, drift_per_s=-0.25)), GRID, lambda _index: lit)
    seen = path.of(np.zeros(4, np.int64), np.zeros((4, 2)), np.array([0.0, 2.0, 4.0, 9.0]))
    assert seen.light.tolist() == pytest.approx([3.0, 1.5, 0.0, 0.0])


def test_each_dark_side_of_a_mirror_costs_its_share_of_light() -> None:
    """A lit stripe of 2 x 8 mirrors, from top to bottom of the field: 16 have a dark side, 4 of them at the ends one more.

    At a loss of 0.1 a side, and 1/4 px a mirror: (16 - 0.1 (16 + 4)) / 4 = 3.5.
    """
    scene = AreaImage(np.ones((1, 1)), 4.0, 0.0, 0.0)
    column = _packed(*[(row, mirror) for row in range(4, 12) for mirror in (10, 11)])
    path = LightPath(ChangingImage(scene), Optics(edge_loss=0.1), GRID, lambda _index: column)
    assert path.of(np.array([0]), np.zeros((1, 2)), np.zeros(1)).light.tolist() == [pytest.approx(3.5)]


@given(seed=st.integers(0, 200), dx=st.floats(-3, 3), dy=st.floats(-3, 3))
def test_a_pattern_and_its_complement_together_see_all_light_of_the_field(seed: int, dx: float, dy: float) -> None:
    rng = np.random.default_rng(seed)
    scene = AreaImage(rng.random((4, 4)), 1.0, 0.0, 0.0)
    plane = np.zeros((16, 24), np.uint8)
    plane[4:12, 8:16] = rng.integers(0, 2, (8, 8))
    other = plane.copy()
    other[4:12, 8:16] ^= 1
    packed = [np.packbits(plane, axis=1), np.packbits(other, axis=1)]
    path = LightPath(ChangingImage(scene), Optics(), GRID, packed.__getitem__)
    light = path.of(np.array([0, 1]), np.array([[dx, dy], [dx, dy]]), np.zeros(2)).light
    assert light.sum() == pytest.approx(float(scene.on_grid(dx, dy, 4, 1.0).sum()), abs=1e-9)


# Noise


def test_pixel_noise_is_drawn_anew_for_each_stretch_of_bins_and_added_to_the_light() -> None:
    """The same seed and stretch give the same noise whatever the light; twice sigma gives twice the noise."""

    def noise(sigma: float, stretch: int, light: float) -> Floats:
        settings = PixelNoise(kind="pixel", sigma=sigma, seed=5)
        lit = np.full(8, 4.0)
        found = measure(
            settings, stretch, light=np.full(8, light), lit_px=lit, duration_s=np.full(8, 5e-5), counts_per_light=9.0
        )
        return found.astype(np.float64) - light

    np.testing.assert_allclose(noise(0.1, 0, 3.0), noise(0.1, 0, 70.0), atol=1e-12)
    np.testing.assert_allclose(noise(0.2, 0, 3.0), 2 * noise(0.1, 0, 3.0), atol=1e-12)
    assert not np.isclose(noise(0.1, 1, 3.0), noise(0.1, 0, 3.0)).any()


def test_photons_come_from_light_and_time_together() -> None:
    """10 of light at 30 photons each and 1e6 dark counts a second in 200 us: 300 + 200, each with its own variance."""
    noise = PhotonNoise(kind="poisson", dark_rate_hz=1e6, seed=2)
    n = 20_000
    counts = measure(
        noise, 0, light=np.full(n, 10.0), lit_px=np.ones(n), duration_s=np.full(n, 2e-4), counts_per_light=30.0
    ).astype(np.float64)
    dead = 1 + 500 * noise.dead_time_s / 2e-4
    assert counts.mean() == pytest.approx(500 / dead, abs=5 * (500 / n) ** 0.5)


def test_a_bin_as_long_as_the_dead_time_counts_one_at_most_and_a_little_longer_two() -> None:
    """Counts, k of them, need k - 1 dead times: the second one has to wait exactly one."""
    rate = np.full(2000, 1e6)
    assert count_photons(rate, np.full(2000, 1.0), 1.0, [3]).max() == 1
    assert count_photons(rate, np.full(2000, 1.1), 1.0, [3]).max() == 2
    assert count_photons(rate, np.full(2000, 2.1), 1.0, [3]).min() == 3


# The bench


def test_counts_are_scaled_to_the_light_of_the_first_picture(tmp_path: Path) -> None:
    """A dot of 0.25 is the whole scene, and so gives peak_counts, 1e6; its neighbour gives none."""
    cells = np.zeros((SIZE, SIZE))
    cells[4, 5] = 0.25
    noise = {"kind": "poisson", "peak_counts": 1e6, "dead_time_s": 0.0, "seed": 1}
    bench = bench_with(tmp_path, object=save(tmp_path, cells), noise=noise)
    found = values(bench, [pixel(4, 5), pixel(4, 6), all_on()])
    assert found[0] == pytest.approx(1e6, abs=5e3)
    assert found[1] == 0
    assert found[2] == pytest.approx(1e6, abs=5e3)


def test_a_mirror_transition_as_long_as_a_picture_shows_half_of_the_picture_before(tmp_path: Path) -> None:
    """Light goes from one picture to the next over 50 us, in the mean half of each; before the first there was none."""
    cells = np.zeros((SIZE, SIZE))
    cells[4, 5] = 1.0
    bench = bench_with(tmp_path, object=save(tmp_path, cells), mirror_transition_s=50e-6)
    assert values(bench, [pixel(4, 5), pixel(0, 0), pixel(4, 5)]) == pytest.approx([0.5, 0.5, 0.5])
