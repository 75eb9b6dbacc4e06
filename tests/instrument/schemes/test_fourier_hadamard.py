"""What six patterns are, in which order they are shown, and what their values mean."""

from typing import Literal

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from instrument.patterns import fringe, hadamard_signs
from instrument.plan import Plan
from instrument.schemes import FourierHadamardSettings, image_rows_of, position_of, scheme_of
from protocols import Floats, PlanError

AXES: tuple[Literal["x", "y"], ...] = ("x", "y")


def test_a_paper_run_has_3336_unique_patterns_and_9997_pictures() -> None:
    """Four Fourier patterns and 2 x 1,666 Hadamard ones; 9,996 pictures and the guard."""
    sequence = scheme_of(Plan(frames=1666)).sequence()

    assert len(sequence.planes) == 3336
    assert len(sequence.play_order) == 9997
    assert len(np.unique(sequence.planes.reshape(3336, -1), axis=0)) == 3336
    assert sequence.play_order[:12].tolist() == [0, 1, 2, 3, 4, 5, 0, 1, 2, 3, 6, 7]


@pytest.mark.parametrize("order", ["tv", "hyperbolic", "natural"])
@pytest.mark.parametrize("shuffle_seed", [None, 3])
def test_every_sequence_ends_dark(order: str, shuffle_seed: int | None) -> None:
    scheme = {"name": "fourier-hadamard", "hadamard_order": order, "shuffle_seed": shuffle_seed}
    plan = Plan.model_validate({"frames": 20, "image_size": 16, "scheme": scheme})
    sequence = scheme_of(plan).sequence()

    assert not sequence.sample_plane(int(sequence.play_order[-1])).any()


def test_the_guard_is_the_complement_of_the_all_one_pattern_where_that_is_shown() -> None:
    """So a run needs no extra plane: 4 + 2 x 5."""
    sequence = scheme_of(Plan(frames=5, image_size=16)).sequence()

    assert len(sequence.planes) == 14
    assert sequence.play_order[-1] == 5


def test_a_field_that_does_not_fit_is_refused() -> None:
    with pytest.raises(PlanError, match="768"):
        scheme_of(Plan(frames=1, image_size=512)).sequence()


@settings(max_examples=15, deadline=None)
@given(
    exponent=st.integers(3, 5),
    frames=st.integers(1, 90),
    upsampling=st.sampled_from([1, 2]),
    shuffle_seed=st.none() | st.integers(0, 9),
)
def test_unpacked_planes_in_play_order_are_the_patterns(
    exponent: int, frames: int, upsampling: int, shuffle_seed: int | None
) -> None:
    """Round trip through packing, deduplication (frames beyond m^2 repeat) and shuffling."""
    size = 2**exponent
    settings = FourierHadamardSettings(upsampling=upsampling, shuffle_seed=shuffle_seed, fourier_cycles=1)
    scheme = scheme_of(Plan(frames=frames, image_size=size, superpixel=2, scheme=settings))
    pairs = image_rows_of(scheme).pairs
    sequence = scheme.sequence()

    assert len(sequence.planes) <= 4 + 2 * min(frames, size**2) + 1
    for frame in {0, frames // 2, frames - 1}:
        shown = [sequence.sample_plane(int(plane)) for plane in sequence.play_order[6 * frame : 6 * frame + 6]]
        np.testing.assert_array_equal(np.stack(shown[:4]), scheme.fixed_patterns)
        np.testing.assert_array_equal(shown[4] + shown[5], 1)
        signs = hadamard_signs(size, pairs[frame : frame + 1])[0].repeat(upsampling, 0).repeat(upsampling, 1)
        np.testing.assert_array_equal(shown[4].astype(np.int8) - shown[5], signs)


def test_a_shuffled_plan_shows_the_same_patterns_in_another_order() -> None:
    plain = image_rows_of(scheme_of(Plan(frames=100))).pairs
    settings = FourierHadamardSettings(shuffle_seed=1)
    shuffled = image_rows_of(scheme_of(Plan(frames=100, scheme=settings))).pairs

    assert shuffled.tolist() != plain.tolist()
    np.testing.assert_array_equal(np.unique(shuffled, axis=0), np.unique(plain, axis=0))


def test_decoding_of_one_frame_by_hand() -> None:
    """S = 6 + 4: over S, 2 x 7 - 10 = 4, 2 x 2 - 10 = -6, 2 x 5 - 10 = 0, 2 x 9 - 10 = 8."""
    scheme = scheme_of(Plan(frames=1))
    values = np.array([[7.0, 2.0, 5.0, 9.0, 6.0, 4.0]])
    total = values @ scheme.light_weights

    assert total.tolist() == [10.0]
    np.testing.assert_allclose(position_of(scheme).signal(values, total) * 10, [[4 - 6j, 0 + 8j]], atol=1e-12)
    np.testing.assert_allclose(
        position_of(scheme).signal(values, np.array([11.0])) * 11, [[3 - 7j, -1 + 7j]], atol=1e-12
    )


def test_each_column_says_what_it_is() -> None:
    columns = scheme_of(Plan(frames=1)).columns

    assert [column.role for column in columns] == ["fourier"] * 4 + ["hadamard"] * 2
    assert [column.axis for column in columns] == ["x", "x", "y", "y", None, None]
    assert [column.sign for column in columns] == [1, 1, 1, 1, 1, -1]
    np.testing.assert_allclose(
        [6 * column.after_middle_frames for column in columns], [-2.5, -1.5, -0.5, 0.5, 1.5, 2.5]
    )


def _signal(image: Floats, shown: list[Floats]) -> tuple[complex, complex]:
    """Coefficients O~(f, 0) and O~(0, f) of an image, from the four values that these fringes give."""
    values = np.array([[float((image * pattern).sum()) for pattern in shown] + [float(image.sum()), 0.0]])
    signal = position_of(scheme_of(Plan(frames=1, image_size=64))).signal(
        values, values.sum(axis=1) - values[:, :4].sum(axis=1)
    )
    x, y = (signal[0] * image.sum()).tolist()
    return x, y


def test_coefficients_of_grey_fringes_are_those_of_the_discrete_fourier_transform() -> None:
    """The sign convention: sum of O exp(-2 pi j f x), so that motion by d multiplies by exp(-2 pi j f d)."""
    image = np.random.default_rng(1).random((64, 64))

    found = _signal(image, [fringe(64, 2, phase, axis) for axis in AXES for phase in (0.0, np.pi / 2)])

    transform = np.fft.fft2(image)
    np.testing.assert_allclose(found, [transform[0, 2], transform[2, 0]], rtol=1e-9)


def test_coefficients_of_the_binary_patterns_miss_by_about_a_hundredth_of_the_light() -> None:
    """A smooth object, four samples a pixel."""
    settings = FourierHadamardSettings(upsampling=4)
    scheme = scheme_of(Plan(frames=1, image_size=64, superpixel=4, scheme=settings))
    row, column = np.mgrid[:64, :64]
    image = np.exp(-((row - 25.0) ** 2 + (column - 37.0) ** 2) / 50)
    sequence = scheme.sequence()
    shares = [sequence.sample_plane(int(k)).reshape(64, 4, 64, 4).mean(axis=(1, 3)) for k in sequence.play_order[:4]]

    found = np.array(_signal(image, shares))

    transform = np.fft.fft2(image)
    missed = np.abs(found - [transform[0, 2], transform[2, 0]]) / image.sum()
    assert 0.001 < missed.max() < 0.02


def test_settings_that_do_not_go_with_the_field_are_refused() -> None:
    with pytest.raises(ValidationError, match="must divide superpixel = 2"):
        Plan(frames=1, scheme=FourierHadamardSettings(upsampling=3))
    with pytest.raises(ValidationError, match="must be below image_size / 2"):
        Plan(frames=1, image_size=16, scheme=FourierHadamardSettings(fourier_cycles=8))
