"""An image that is larger than the field, of an object that passes by."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from instrument import Plan, Recording, reconstruct, simulate
from instrument.joint import refine
from instrument.numerics import InTime, psnr
from instrument.patterns import walsh_matrix
from instrument.reconstruction import Field, FixedPatterns, Region, ShiftedHadamard, field_in
from instrument.reconstruction.window_rows import WindowRows
from protocols import Floats, InputError

SIZE, FRAMES = 32, 500


def test_the_field_sees_of_a_passing_object_what_its_path_uncovers() -> None:
    """Moved by up to 10.2 px to the right, pixels from -10.2 on are seen; by 2.5 px down and 3.5 px up, from -2.5 to 32 + 3.5."""
    region = Region.seen(np.array([[0.0, 2.5], [10.2, -3.5]]), SIZE)
    assert region == Region(top=-3, left=-11, height=39, width=43)
    assert Region.seen(np.zeros((2, 2)), SIZE) == Region.whole(SIZE)
    assert region.wider(2) == Region(top=-5, left=-13, height=43, width=47)


def test_an_image_of_a_region_outside_holds_the_field_too() -> None:
    region = Region(top=3, left=-4, height=2, width=5)
    image = region.paste(np.arange(10.0).reshape(2, 5), 8)
    assert image.shape == (8, 12)
    assert field_in(region, 8) == Region(top=0, left=4, height=8, width=8)
    np.testing.assert_array_equal(image[3:5, :5], np.arange(10.0).reshape(2, 5))
    assert image.sum() == 45
    assert Region(top=6, left=2, height=4, width=3).paste(np.ones((8, 6)), 8).shape == (20, 16)


@settings(max_examples=25, deadline=None)
@given(
    st.integers(-20, 20),
    st.integers(-20, 20),
    st.integers(1, 40),
    st.integers(1, 40),
    st.integers(1, 2),
    st.integers(0, 99),
)
def test_rows_of_a_wide_region_are_those_of_the_sum_over_pixels(  # noqa: PLR0917
    top: int, left: int, height: int, width: int, grid: int, seed: int
) -> None:
    """A whole-pixel displacement of a pattern pixel: value = sum over the field of P(u) O(u - d), written out."""
    rng = np.random.default_rng(seed)
    region, size = Region(top, left, height, width), 8
    field = Field(size, grid)
    image = rng.random((height * grid, width * grid)).astype(np.float32)
    places = rng.integers(-12, 12, (6, 2)).astype(np.float64)
    pairs = rng.integers(0, size, (6, 2))
    rows = ShiftedHadamard.single(pairs, places, field, region).matvec(image.ravel())
    patterns = np.concatenate([np.ones((1, size, size)), rng.integers(0, 2, (2, size, size))]).astype(np.uint8)
    acting = field.acting(patterns)
    sigma = np.array([[1.0, 2.0, 4.0]]).repeat(6, axis=0)
    window = WindowRows.of(acting, places[:, None].repeat(3, axis=1), sigma, field, region)
    values = window.matvec(image.ravel()).reshape(6, 3)
    maps = FixedPatterns.of(acting, field, region)
    by_maps = maps.values(maps.maps(image), places[:, None].repeat(3, axis=1))[0]

    walsh = walsh_matrix(size)
    light = image.reshape(height, grid, width, grid).mean(axis=(1, 3))
    for k in range(6):
        there = np.zeros((size, size))
        for y in range(height):
            for x in range(width):
                row, column = y + top + int(places[k, 1]), x + left + int(places[k, 0])
                if 0 <= row < size and 0 <= column < size:
                    there[row, column] = light[y, x]
        assert rows[k] == pytest.approx(float(walsh[pairs[k, 0]] @ there @ walsh[pairs[k, 1]]), abs=1e-3)
        total = there.sum()
        expected = [total, ((patterns[1] * there).sum() - total / 2) / 2, ((patterns[2] * there).sum() - total / 2) / 4]
        np.testing.assert_allclose(values[k], expected, atol=1e-3)
        np.testing.assert_allclose(by_maps[k], (patterns * there).sum(axis=(1, 2)), atol=1e-3)
    seen, back = rng.standard_normal(18).astype(np.float32), rng.standard_normal(image.size).astype(np.float32)
    assert np.vdot(window.matvec(back), seen) == pytest.approx(np.vdot(back, window.rmatvec(seen)), abs=2e-2)


def test_terms_over_time_keep_what_they_weigh_fully_and_no_row_is_too_long() -> None:
    """Fully weighted cosine terms of white rows are a rotation of them: their lengths together stay the same."""
    rng = np.random.default_rng(1)
    field, region = Field(8), Region(0, -20, 8, 28)
    places = np.stack([np.linspace(0, 20, 40), np.zeros(40)], axis=1)[:, None]
    window = WindowRows.of(field.acting(np.ones((1, 8, 8), np.uint8)), places, np.ones((40, 1)), field, region)
    image = rng.random(8 * 28).astype(np.float32)
    free, bound = InTime.of(window, 1, 1e9), InTime.of(window, 1, 8.0)
    assert (free.weight == 1).all()
    kept = free.matvec(image)
    assert np.vdot(kept, kept) == pytest.approx(float(np.vdot(window.matvec(image), window.matvec(image))), rel=1e-3)
    shares = (window.matvec(np.eye(28 * 8, dtype=np.float32)[k]).mean() for k in range(28 * 8))
    longest = np.sqrt(40 * sum(float(share) ** 2 for share in shares))  # length of the row of the mean over time
    assert bound.weight[0, 0] == pytest.approx(8 / longest, rel=0.5)
    assert InTime.of(window, 1, 8.0, steady=False).weight[0, 0] == 0
    values = rng.standard_normal(bound.shape[0]).astype(np.float32)
    assert np.vdot(bound.matvec(image), values) == pytest.approx(float(np.vdot(image, bound.rmatvec(values))), rel=1e-3)


def _wide_object() -> Floats:
    """A frame with two bars in it, 20 x 56 px: wider than the field."""
    image = np.zeros((20, 56))
    image[[0, 1, 18, 19]] = 1
    image[:, [0, 1, 54, 55]] = 1
    image[6:14, 10:18] = image[4:16, 34:38] = 1
    return image


@pytest.fixture(scope="module")
def passing(tmp_path_factory: pytest.TempPathFactory) -> Recording:
    """The object of ``_wide_object`` goes 40 px to the right through a field of 32 px; at frame 0 its left end is at -30."""
    file = tmp_path_factory.mktemp("wide") / "object.npy"
    np.save(file, _wide_object())
    plan = Plan(frames=FRAMES, image_size=SIZE)
    scene = {
        "object": str(file),
        "object_height_px": 20.0,
        "start_px": [-2.0, 16.0],
        "noise": {"kind": "pixel", "sigma": 0.05, "seed": 1},
    }

    def path(time_s: Floats) -> Floats:
        return np.stack([40 * time_s / plan.run_time_s, np.zeros_like(time_s)], axis=1)

    return simulate(plan, scene, path=path)


def test_the_image_of_a_passing_object_is_larger_than_the_field(passing: Recording) -> None:
    assert passing.truth is not None
    way = passing.truth.displacement_px
    found = reconstruct(passing, way, region="wide")
    assert found.image.shape == (32, 73)  # frame 0 is in its middle half a pattern's way on
    assert (found.field, found.wide) == (Region(0, 40, 32, 32), True)
    assert found.in_field.shape == (32, 32)
    true = np.zeros((32, 73))
    true[6:26, 10:66] = _wide_object()
    assert psnr(found.image[:, 30:], true[:, 30:]) > 20
    assert psnr(found.image, true) > 14  # coarse patterns were over when the left end came into the field
    inside = reconstruct(passing, way, region="field")
    assert inside.image.shape == (32, 32)
    assert psnr(found.in_field, true[:, 40:72]) > psnr(inside.image, true[:, 40:72]) + 3


def test_a_rectangle_of_ones_own_is_refined_as_a_wide_region_is(passing: Recording) -> None:
    """No offsets are taken from circles, no finer grid and no lost frame are looked for."""
    assert passing.truth is not None
    wide = Region.seen(passing.truth.displacement_px, SIZE)
    found = refine(passing, passing.truth.displacement_px, region=wide, grid=None, background="none")
    assert found.image.region == wide
    assert found.image.grid == 1
    assert found.lost_frame is None


def test_a_rectangle_without_pixels_is_refused() -> None:
    with pytest.raises(InputError, match="0 x 5 px"):
        Region(0, 0, 0, 5)


def test_a_diagonal_path_that_would_fill_the_memory_is_refused_before_it_does() -> None:
    """At 256 px, a path of 240 px along both axes: 5 patterns, 241 rows, 256 of the image, 376 frequencies: 0.9 GB."""
    path_px = np.repeat(np.linspace(0, 240, 20)[:, None, None], 5, axis=1) * np.ones(2)
    region, field = Region.seen(path_px[:, 0], 256), Field(256)
    with pytest.raises(InputError, match="along rows or along columns"):
        WindowRows.of(np.ones((5, 256, 256), np.float32), path_px, np.ones((20, 5)), field, region)


def test_an_unknown_region_is_refused(passing: Recording) -> None:
    with pytest.raises(InputError, match="the region 'whole'"):
        reconstruct(passing, None, region="whole")  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]


def test_a_shape_that_changes_is_not_sought_of_what_passes_by(passing: Recording) -> None:
    assert passing.truth is not None
    with pytest.raises(InputError, match="changing shape"):
        refine(passing, passing.truth.displacement_px, region="wide", shape="changing")
