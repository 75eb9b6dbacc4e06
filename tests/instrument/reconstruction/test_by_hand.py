"""Operators, transforms and problems small enough to be worked out by hand or written out as matrices."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from instrument.measurement import Measurement
from instrument.patterns import hadamard_order, hadamard_signs
from instrument.patterns.hadamard import HadamardOrder
from instrument.plan import Plan
from instrument.reconstruction import Field, Region, ShiftedHadamard, inverse_hadamard
from instrument.reconstruction.dgi import ghost_image
from instrument.reconstruction.problem import Places, Problem
from instrument.recording import Recording
from instrument.tracking import Trajectory
from protocols import Floats, InputError, Singles
from tests.support.dense import DenseSingles, dense_differential, seen_patterns
from tests.support.plans import plan_of

seeds = st.integers(0, 1000)


def _normal(count: int, seed: int) -> Floats:
    return np.random.default_rng(seed).standard_normal(count)


# The operator


@given(seed=seeds, rows=st.integers(1, 12))
def test_terms_are_added_with_their_coefficients_each_at_its_own_place(seed: int, rows: int) -> None:
    rng = np.random.default_rng(seed)
    coefficients = [0.5, -2.0, 3.0]
    pairs = rng.integers(0, 8, (3, rows, 2))
    places = rng.uniform(-5, 5, (3, rows, 2))
    operator = ShiftedHadamard.of(coefficients, pairs, places, Field(8))
    dense = sum(
        coefficients[term] * seen_patterns(hadamard_signs(8, pairs[term]).astype(np.float64), places[term])
        for term in range(3)
    )
    image = _normal(64, seed).astype(np.float32)
    assert (operator.shape, operator.image_shapes[0]) == ((rows, 64), (8, 8))
    np.testing.assert_allclose(operator.matvec(image), np.reshape(dense, (rows, 64)) @ image, atol=1e-3)


@pytest.mark.parametrize(("way_px", "value"), [(0.04, 63.84), (0.06, 64.0)])
def test_places_up_to_a_twentieth_of_a_pixel_apart_are_one_place(way_px: float, value: float) -> None:
    """All-one pattern of 8 x 8 at 0, its dark complement at ``way_px``: 64, or 8 (8 - 0.02) where both are at their mean."""
    still = np.zeros((1, 2))
    operator = ShiftedHadamard.differential(np.array([[0, 0]]), still, np.array([[way_px, 0.0]]), Field(8))
    assert float(operator.matvec(np.ones(64, np.float32))[0]) == pytest.approx(value, abs=1e-4)


@pytest.mark.parametrize(("way_px", "value"), [(1.5, 54.0), (1.99, 52.04), (2.0, 56.0)])
def test_of_a_region_that_stays_inside_a_change_of_the_total_light_is_left_out(way_px: float, value: float) -> None:
    """Seven of eight columns, at 0 and to the right: the mean of 56 and 8 (8 - way). If one goes out: 56. Of the whole: 64."""
    still, moved = np.zeros((1, 2)), np.array([[way_px, 0.0]])
    pairs = np.array([[0, 0]])
    part = ShiftedHadamard.differential(pairs, still, moved, Field(8), Region(0, 0, 8, 7))
    assert float(part.matvec(np.ones(56, np.float32))[0]) == pytest.approx(value, abs=1e-4)
    whole = ShiftedHadamard.differential(pairs, still, moved, Field(8), Region.whole(8))
    assert whole.matvec(np.ones(64, np.float32)).tolist() == [64.0]


def test_an_operator_without_rows_gives_no_values_and_a_dark_image() -> None:
    nothing = np.zeros((0, 2))
    operator = ShiftedHadamard.differential(np.zeros((0, 2), np.int64), nothing, nothing, Field(8))
    assert operator.shape == (0, 64)
    assert operator.matvec(np.ones(64, np.float32)).shape == (0,)
    assert operator.rmatvec(np.zeros(0, np.float32)).tolist() == [0.0] * 64


# The inverse transform


@pytest.mark.parametrize("order", ["tv", "hyperbolic", "natural"])
@given(seed=seeds)
def test_it_does_not_matter_in_which_sequence_coefficients_come(order: HadamardOrder, seed: int) -> None:
    pairs, values = hadamard_order(8, order), _normal(64, seed)
    mixed = np.random.default_rng(seed).permutation(64)
    np.testing.assert_allclose(
        inverse_hadamard(values[mixed], pairs[mixed], 8), inverse_hadamard(values, pairs, 8), atol=1e-12
    )


@given(seed=seeds, count=st.integers(1, 64))
def test_an_image_has_the_energy_of_its_coefficients_over_its_pixels(seed: int, count: int) -> None:
    """Parseval for rows of squared length 64: sum O^2 = sum I^2 / 64, however many coefficients are left out."""
    values = _normal(count, seed)
    image = inverse_hadamard(values, hadamard_order(8, "tv", count), 8)
    assert np.square(image).sum() == pytest.approx(np.square(values).sum() / 64)


def test_a_single_coefficient_gives_its_pattern_in_its_orientation() -> None:
    """16 of the pattern + + - - across, even down: 1 to the left and -1 to the right."""
    image = inverse_hadamard(np.array([16.0]), np.array([[0, 1]]), 4)
    assert image.tolist() == [[1, 1, -1, -1]] * 4


# Ghost imaging


def _operator(matrix: Floats, shape: tuple[int, int]) -> DenseSingles:
    return DenseSingles(matrix, shape)


def test_a_ghost_image_of_two_pixels_by_hand() -> None:
    """Values 3 and 1 of two patterns with one lit pixel each: <B P> = (1.5, 0.5), and (2 / 1) <R P> = (1, 1)."""
    image = ghost_image(_operator(np.eye(2), (1, 2)), np.array([3, 1], np.float32), np.ones(2, np.float32))
    assert image.tolist() == [[0.5, -0.5]]


@given(seed=seeds, level=st.floats(-3, 3), gain=st.floats(0.1, 10))
def test_light_in_proportion_to_the_patterns_stays_out_of_a_ghost_image(seed: int, level: float, gain: float) -> None:
    """B to gain B + level R changes G to gain G: background light of any brightness is taken off."""
    matrix = np.random.default_rng(seed).random((30, 12))
    operator, light = _operator(matrix, (3, 4)), matrix.sum(axis=1).astype(np.float32)
    values: Singles = _normal(30, seed).astype(np.float32)
    image = ghost_image(operator, values, light)
    other = ghost_image(operator, (gain * values + level * light).astype(np.float32), light)
    assert image.shape == (3, 4)
    np.testing.assert_allclose(other, gain * image, atol=1e-3)


# The problem


def _measured(frames: int = 6, size: int = 16) -> Measurement:
    values = np.random.default_rng(4).uniform(40, 60, (frames, 6))
    recording = Recording(Plan(frames=frames, image_size=size), values, np.ones(frames, np.bool_), 50e-6)
    return Measurement.of(recording)


def _way(step_px: tuple[float, float], frames: int = 6) -> Trajectory:
    """Constant velocity, and 0.3 ms a frame: six pictures of 50 us."""
    way = np.outer(np.arange(frames), step_px)
    return Trajectory(way, np.zeros((frames, 2)), 3e-4, "given", np.ones(frames, np.bool_))


def test_each_pattern_is_taken_where_the_object_is_in_its_middle() -> None:
    """3 px a frame across: four fringes, then H+ and H-, 0.5 px apart. The middle of frame 0 is between its third and fourth."""
    values = _measured().image_values(steady_object=False)
    places = Places.along(_way((3.0, 0.0)), values)
    np.testing.assert_allclose(places.fixed[0, :, 0], [-1.25, -0.75, -0.25, 0.25], atol=1e-12)
    np.testing.assert_allclose([places.positive[0, 0], places.negative[0, 0]], [0.75, 1.25], atol=1e-12)
    np.testing.assert_allclose(places.positive[:, 0], 0.75 + 3.0 * np.arange(6), atol=1e-12)
    assert not places.every_px[:, 1].any()
    assert places.every_px.shape == (6 * 6, 2)


def test_an_object_inside_the_field_is_looked_for_where_it_fits() -> None:
    """1 px a frame down: from -0.417 to 5.417 px over six frames of six patterns. Region: all columns, and rows up to 16 - 5."""
    measured = _measured()
    values = measured.image_values(steady_object=False)
    problem = Problem.of(measured, values, _way((0.0, 1.0)), region="inside")
    assert problem.region == Region(top=0, left=0, height=11, width=16)
    assert Problem.of(measured, values, _way((0.0, 1.0)), region="field").region == Region.whole(16)
    moved = problem.moved(_way((0.0, -0.5)))
    assert moved.region == problem.region
    assert moved.places.positive[5, 1] == pytest.approx(-0.125 - 2.5)


def test_rows_and_values_of_a_problem_are_divided_by_their_standard_deviation() -> None:
    measured = _measured()
    values = measured.image_values(steady_object=False)
    sigma = np.linspace(1.0, 6.0, 6)
    values = replace(values, difference_variance=sigma**2)
    problem = Problem.of(measured, values, _way((0.6, 0.3)), region="field")
    operator, whitened = problem.hadamard()
    np.testing.assert_allclose(whitened, (values.positive - values.negative) / sigma, rtol=1e-5)
    dense = dense_differential(values.pairs, problem.places.positive, problem.places.negative, 16)
    image = _normal(256, 8)
    np.testing.assert_allclose(operator.matvec(image.astype(np.float32)), dense.matvec(image) / sigma, atol=1e-3)


def test_a_scheme_without_fringes_has_no_fourier_rows() -> None:
    frames = 6
    values = np.random.default_rng(4).uniform(
        40, 60, (frames, plan_of("moment-hadamard", frames, 16).patterns_per_frame)
    )
    recording = Recording(plan_of("moment-hadamard", frames, 16), values, np.ones(frames, np.bool_), 50e-6)
    measured = Measurement.of(recording)
    problem = Problem.of(measured, measured.image_values(steady_object=False), _way((0.1, 0.0)), region="field")
    with pytest.raises(InputError, match="the method tv-fourier for the scheme moment-hadamard"):
        problem.with_fourier()
