"""What the eight patterns of four-step Fourier tracking are, and what their values mean."""

from typing import Literal

import numpy as np
import pytest

from instrument.patterns import fringe
from instrument.reconstruction import reconstruct
from instrument.schemes import position_of, scheme_of
from instrument.tracking import track
from protocols import Floats, InputError
from tests.support.motions import letter_b
from tests.support.plans import plan_of
from tests.support.simulation import simulate

AXES: tuple[Literal["x", "y"], ...] = ("x", "y")
PHASES = (0.0, np.pi / 2, np.pi, 3 * np.pi / 2)


def test_decoding_of_one_frame_by_hand() -> None:
    """O~ = (7 - 3) + j (6 - 4) along x and (2 - 8) + j (5 - 5) along y; S = 20 / 2 = 10 along both axes."""
    scheme = scheme_of(plan_of("fourier-4step", frames=1))
    values = np.array([[7.0, 6, 3, 4, 2, 5, 8, 5]])
    total = values @ scheme.light_weights

    assert total.tolist() == [10.0]
    np.testing.assert_allclose(position_of(scheme).signal(values, total) * 10, [[4 + 2j, -6]], atol=1e-12)


def test_each_column_says_what_it_is() -> None:
    columns = scheme_of(plan_of("fourier-4step", frames=1)).columns

    assert [column.role for column in columns] == ["fourier"] * 8
    assert [column.axis for column in columns] == ["x"] * 4 + ["y"] * 4
    np.testing.assert_allclose([column.phase_rad for column in columns], [*PHASES, *PHASES])
    np.testing.assert_allclose([8 * c.after_middle_frames for c in columns], np.arange(8) - 3.5)


def test_fringes_half_a_period_apart_add_to_the_all_on_pattern_exactly() -> None:
    patterns = scheme_of(plan_of("fourier-4step", frames=1, image_size=32)).fixed_patterns

    for first, opposite in ((0, 2), (1, 3), (4, 6), (5, 7)):
        np.testing.assert_array_equal(patterns[first] + patterns[opposite], np.ones((32, 32)))


def test_each_pattern_is_the_fringe_of_its_column() -> None:
    """Dithered at four samples a side: means over 16 x 16 samples are within 0.05 of the grey fringe's."""
    scheme = scheme_of(plan_of("fourier-4step", frames=1, image_size=32, upsampling=4))
    for column, pattern in zip(scheme.columns, scheme.fixed_patterns, strict=True):
        assert column.axis is not None
        grey = fringe(32, 2, column.phase_rad, column.axis).reshape(8, 4, 8, 4).mean(axis=(1, 3))
        np.testing.assert_allclose(pattern.reshape(8, 16, 8, 16).mean(axis=(1, 3)), grey, atol=0.05)


def test_coefficients_of_grey_fringes_are_those_of_the_discrete_fourier_transform() -> None:
    image = np.random.default_rng(1).random((32, 32))
    values = np.array([[float((image * fringe(32, 2, phase, axis)).sum()) for axis in AXES for phase in PHASES]])
    scheme = scheme_of(plan_of("fourier-4step", frames=1, image_size=32))
    total = values @ scheme.light_weights

    transform = np.fft.fft2(image)
    assert total == pytest.approx([image.sum()])
    np.testing.assert_allclose(
        position_of(scheme).signal(values, total) * image.sum(), [[transform[0, 2], transform[2, 0]]], rtol=1e-9
    )


def test_a_run_has_nine_unique_patterns_whatever_its_length() -> None:
    """Eight fringes and the dark guard."""
    sequence = scheme_of(plan_of("fourier-4step", frames=500, image_size=32)).sequence()

    assert len(np.unique(sequence.planes.reshape(9, -1), axis=0)) == 9
    assert sequence.play_order[:9].tolist() == [0, 1, 2, 3, 4, 5, 6, 7, 0]
    assert (len(sequence.play_order), int(sequence.play_order[-1])) == (8 * 500 + 1, 8)
    assert not sequence.sample_plane(8).any()


def _diagonal(time_s: Floats) -> Floats:
    return np.stack([200 * time_s, 100 * time_s], axis=1)


def test_a_path_is_given_and_an_image_is_refused() -> None:
    """40 frames of 0.4 ms at 200 and 100 px/s: 39 steps are 3.12 and 1.56 px."""
    recording = simulate(plan_of("fourier-4step", frames=40), letter_b(), _diagonal)

    np.testing.assert_allclose(track(recording).displacement_px[-1], [3.12, 1.56], atol=0.3)
    with pytest.raises(InputError, match="the scheme fourier-4step, which only tracks"):
        reconstruct(recording, None)
