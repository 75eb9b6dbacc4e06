"""What the six patterns of Zhang 2019 are, and what their values mean."""

from typing import Literal

import numpy as np
import pytest

from instrument.analysis import analyse
from instrument.joint import refine
from instrument.patterns import fringe
from instrument.reconstruction import reconstruct
from instrument.schemes import position_of, scheme_of
from protocols import Floats, InputError
from tests.support.motions import letter_b
from tests.support.plans import plan_of
from tests.support.simulation import simulate

AXES: tuple[Literal["x", "y"], ...] = ("x", "y")
PHASES = (0.0, 2 * np.pi / 3, 4 * np.pi / 3)


def test_a_run_has_seven_unique_patterns_whatever_its_length() -> None:
    """Six fringes and the guard, which no fringe is dark enough for."""
    sequence = scheme_of(plan_of("fourier-3step", frames=1666)).sequence()

    assert len(sequence.planes) == 7
    assert len(np.unique(sequence.planes.reshape(7, -1), axis=0)) == 7
    assert len(sequence.play_order) == 6 * 1666 + 1
    assert sequence.play_order[:7].tolist() == [0, 1, 2, 3, 4, 5, 0]
    assert sequence.play_order[-1] == 6
    assert not sequence.sample_plane(6).any()


def test_decoding_of_one_frame_by_hand() -> None:
    """By the paper's formula, 2 x 6 - 3 - 3 = 6 and 3 - 3 = 0 along x, 2 x 4 - 5 - 3 = 0 and 5 - 3 = 2 along y.

    S = 2/3 x 12 = 8 along both axes. O~ is 2/3 x 6 = 4 along x, and j 2/sqrt3 x 2 along y.
    """
    scheme = scheme_of(plan_of("fourier-3step", frames=1))
    values = np.array([[6.0, 3.0, 3.0, 4.0, 5.0, 3.0]])
    total = values @ scheme.light_weights

    assert total == pytest.approx([8.0])
    np.testing.assert_allclose(position_of(scheme).signal(values, total) * 8, [[4.0, 4j / np.sqrt(3)]], atol=1e-12)


def test_light_that_every_pattern_sees_alike_does_not_turn_the_phase() -> None:
    values = np.array([[6.0, 3.0, 3.0, 4.0, 5.0, 3.0]])
    scheme = scheme_of(plan_of("fourier-3step", frames=1))
    reading = position_of(scheme)

    plain, hazy = (reading.signal(v, v @ scheme.light_weights) for v in (values, values + 10.0))

    np.testing.assert_allclose(np.angle(hazy), np.angle(plain), atol=1e-12)


def test_each_column_says_what_it_is() -> None:
    columns = scheme_of(plan_of("fourier-3step", frames=1)).columns

    assert [column.role for column in columns] == ["fourier"] * 6
    assert [column.axis for column in columns] == ["x", "x", "x", "y", "y", "y"]
    np.testing.assert_allclose([column.phase_rad for column in columns], [*PHASES, *PHASES])
    np.testing.assert_allclose(
        [6 * column.after_middle_frames for column in columns], [-2.5, -1.5, -0.5, 0.5, 1.5, 2.5]
    )


def test_coefficients_of_grey_fringes_are_those_of_the_discrete_fourier_transform() -> None:
    """And 1/3 of the sum of all six values is the light of the image."""
    image = np.random.default_rng(1).random((64, 64))
    values = np.array([[float((image * fringe(64, 2, phase, axis)).sum()) for axis in AXES for phase in PHASES]])
    scheme = scheme_of(plan_of("fourier-3step", frames=1, image_size=64))
    total = values @ scheme.light_weights

    transform = np.fft.fft2(image)
    assert total == pytest.approx([image.sum()])
    np.testing.assert_allclose(
        position_of(scheme).signal(values, total) * image.sum(), [[transform[0, 2], transform[2, 0]]], rtol=1e-9
    )


def _diagonal(time_s: Floats) -> Floats:
    return np.stack([200 * time_s, 100 * time_s], axis=1)


def test_an_image_is_refused_and_a_path_is_given() -> None:
    """40 frames of 0.3 ms at 200 and 100 px/s: 39 steps are 2.34 and 1.17 px."""
    recording = simulate(plan_of("fourier-3step", frames=40), letter_b(), _diagonal)

    with pytest.raises(InputError, match="the scheme fourier-3step, which only tracks"):
        reconstruct(recording, None)
    with pytest.raises(InputError, match="the scheme fourier-3step, which only tracks"):
        refine(recording, np.zeros((40, 2)))
    found = analyse(recording)
    assert found.image is None
    assert found.ignored is None
    assert found.trajectory is not None
    np.testing.assert_allclose(found.trajectory.displacement_px[-1], [2.34, 1.17], atol=0.3)
    assert found.figures.psnr_db is None
    assert found.figures.misfit is None
    rows = {"frames", "travel", "stated uncertainty", "displacement MSE", "analysis"}
    motion = {"travel in px", "speed, mid-run", "speed, start", "speed, end", "acceleration"}
    assert set(found.figures.rows()) == rows | motion
