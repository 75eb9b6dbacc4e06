"""What an image's own uncertainty adds to that of a path: its derivatives against the real ones, and where it adds nothing."""

from dataclasses import replace

import numpy as np
import pytest
from numpy.polynomial.legendre import legvander

from instrument.joint.detail import Picture
from instrument.joint.evidence import evidence_of
from instrument.joint.image_cells import Cells, cells_of
from instrument.joint.image_doubt import by_image_px2
from instrument.joint.iterate import Iterate
from instrument.joint.path_step import path_step
from instrument.joint.prediction import Predictor
from instrument.joint.stated import stated
from instrument.measurement import Measurement
from instrument.numerics import TvState
from instrument.plan import Plan
from instrument.reconstruction import Problem
from instrument.tracking import Trajectory
from protocols import Floats
from tests.support.objects import blobs
from tests.support.simulation import simulate

SIZE, FRAMES = 32, 96
OBJECT = np.roll(blobs(SIZE, 3), (-10, -10), (0, 1))  # inside the field all the time


def _path(time_s: Floats) -> Floats:
    return np.outer(time_s / 30e-3, [3.0, -2.0])


@pytest.fixture(scope="module")
def iterate() -> Iterate:
    """A run with noise on every pixel, and its true path, as one refinement would have left it."""
    recording = simulate(Plan(frames=FRAMES, image_size=SIZE), OBJECT, _path, sigma=0.03)
    assert recording.truth is not None
    measurement = Measurement.of(recording)
    valid = np.ones(FRAMES, np.bool_)
    path = Trajectory(recording.truth.displacement_px, np.ones((FRAMES, 2)), 300e-6, "joint", valid)
    values = measurement.image_values(steady_object=False)
    return Iterate(measurement, Problem.of(measurement, values, path, region="field"), path, 1)


def _picture(iterate: Iterate, strength: float = 3.0) -> Picture:
    image = OBJECT.astype(np.float32)
    state = replace(TvState.zero(((SIZE, SIZE),), 1.0), images=(image,), misfit=1.0)
    return Picture(iterate, state, strength)


def _added(picture: Picture) -> Floats:
    problem, image = picture.iterate.problem, picture.state.image
    prediction = Predictor.of(problem).predict(problem, image, None)
    evidence = evidence_of(problem, prediction, np.zeros(4))
    fits = path_step(evidence, problem.values.frame, picture.iterate.trajectory).fits
    return by_image_px2(picture, evidence, prediction, fits)


def _cells(iterate: Iterate, times: int) -> Cells:
    (cells,) = cells_of(_picture(iterate))
    lit = np.ones((SIZE // times, SIZE // times), np.bool_)
    return replace(cells, times=times, lit=lit, image=np.zeros(lit.shape))


@pytest.mark.parametrize("turns", [False, True])
@pytest.mark.parametrize("times", [1, 2])
def test_rows_are_those_of_the_solver_for_each_cell(iterate: Iterate, times: int, turns: bool) -> None:  # noqa: FBT001
    if turns:
        path = replace(iterate.trajectory, angle_deg=np.linspace(0.0, 5.0, FRAMES), magnification=np.ones(FRAMES))
        iterate = iterate.along(path).about(np.array([16.0, 16.0]))
    cells, (operator, _) = _cells(iterate, times), iterate.problem.hadamard()
    cell = np.zeros((SIZE, SIZE), np.float32)
    cell[6 : 6 + times, 10 : 10 + times] = 1.0
    own = cells.rows(slice(8, 90))[:, (6 // times) * (SIZE // times) + 10 // times]
    assert np.abs(own).max() > 0
    np.testing.assert_allclose(own, operator.matvec(cell.ravel())[8:90], atol=0.05 * np.abs(own).max())


@pytest.mark.parametrize("times", [1, 2])
def test_position_values_change_with_a_cell_as_the_prediction_does(iterate: Iterate, times: int) -> None:
    """Weights and derivatives drawn at random: their sum over rows is the change of the predicted values by one cell."""
    problem, image = iterate.problem, OBJECT.astype(np.float32)
    predictor = Predictor.of(problem)
    before = predictor.predict(problem, image, None)
    brighter = image.copy()
    brighter[12 : 12 + times, 16 : 16 + times] += 0.5
    change = (predictor.predict(problem, brighter, None).values - before.values) / 0.5
    rng = np.random.default_rng(3)
    alongs = [np.zeros((FRAMES, 4)) for _ in range(2)]
    alongs[0][:, :2], alongs[1][:, 2:] = rng.standard_normal((2, FRAMES, 2))
    positions = [rng.standard_normal((FRAMES, 3)) for _ in range(2)]
    found = _cells(iterate, times).of_position(alongs, positions, before)
    expected = sum(position.T @ (along * change).sum(axis=1) for along, position in zip(alongs, positions, strict=True))
    np.testing.assert_allclose(found[(12 // times) * (SIZE // times) + 16 // times], expected, rtol=1e-3, atol=1e-3)


def test_a_step_is_free_by_its_penalty_and_by_its_own_size(iterate: Iterate) -> None:
    """Of two lit cells of 0 and 1 the brighter is typical: the step of 1 takes a sixth of the penalty lambda.

    Its variance is 3 (6 / lambda)^2 + 1; that of steps to the dark around it is alike, and a step of 0 has 3 / lambda^2.
    """
    sigma = iterate.problem.values.difference_sigma
    penalty = 3.0 * np.sqrt(np.sum(1 / sigma**2))
    cells = _cells(iterate, 1)
    image, lit = np.zeros((3, 4)), np.zeros((3, 4), np.bool_)
    image[1, 2], lit[1, 1:3] = 1.0, True
    edge, flat = 1 / (3 * (6 / penalty) ** 2 + 1), penalty**2 / 3
    found = replace(cells, image=image, lit=lit).precision()
    np.testing.assert_allclose(found, [[edge + 3 * flat, -edge], [-edge, 4 * edge]])


def test_an_image_that_is_known_adds_nothing_and_one_that_is_open_more(iterate: Iterate) -> None:
    known, usual, open_ = (_added(_picture(iterate, strength))[-1] for strength in (1e5, 3.0, 0.3))
    assert (known < 0.5 * usual).all()
    assert (usual < open_).all()
    assert (usual > 0).all()


def test_more_rounds_let_more_of_the_motion_go_into_the_image(iterate: Iterate) -> None:
    rounds = [_added(_picture(replace(iterate, refinements=count)))[1:].mean() for count in (1, 2, 6)]
    assert rounds[0] < rounds[1] < rounds[2]


def test_nothing_is_added_at_frame_0_nor_by_a_dark_image(iterate: Iterate) -> None:
    picture = _picture(iterate)
    assert not _added(picture)[0].any()
    state = replace(picture.state, images=(np.zeros((SIZE, SIZE), np.float32),))
    problem = iterate.problem
    prediction = Predictor.of(problem).predict(problem, picture.state.image, None)
    evidence = evidence_of(problem, prediction, np.zeros(4))
    fits = path_step(evidence, problem.values.frame, iterate.trajectory).fits
    assert not by_image_px2(replace(picture, state=state), evidence, prediction, fits).any()


def test_errors_drawn_and_carried_through_three_rounds_scatter_as_stated(iterate: Iterate) -> None:
    """Noise, true image and true modes are drawn; each round finds the image along the path, and then the path with it."""
    picture = _picture(replace(iterate, refinements=3), strength=0.5)
    problem, frame = iterate.problem, iterate.problem.values.frame
    prediction = Predictor.of(problem).predict(problem, picture.state.image, None)
    evidence = evidence_of(problem, prediction, np.zeros(4))
    fits = path_step(evidence, frame, iterate.trajectory).fits
    stated = by_image_px2(picture, evidence, prediction, fits)[-1]

    (cells,) = cells_of(picture)
    modes = np.asarray(legvander(np.linspace(-1, 1, FRAMES), 7), np.float64)

    def by_modes(slope: Floats) -> Floats:
        return np.hstack([slope[:, axis, None] * modes[frame] for axis in range(2)])

    rows, every = cells.rows(slice(None)).astype(np.float64), np.eye(FRAMES)
    seen = [
        rows,
        *(
            cells.of_position([view.by_offset / prediction.total[:, None]], [every], prediction).T
            for view in evidence.axes
        ),
    ]
    slopes = [by_modes(view.slope) for view in (evidence.hadamard, evidence.x.position, evidence.y.position)]
    prior = np.zeros((16, 16))
    prior[:8, :8], prior[8:, 8:] = (fit.precision_of(modes) for fit in fits)
    gain = np.linalg.inv(sum((slope.T @ slope for slope in slopes), start=prior))
    precision = cells.precision()
    covariance = np.linalg.inv(rows.T @ rows + precision)

    rng, draws = np.random.default_rng(5), 4000
    noise = [rng.standard_normal((FRAMES, draws)) for _ in slopes]
    own = np.linalg.cholesky(precision) @ rng.standard_normal((len(precision), draws))
    values, vectors = np.linalg.eigh(prior)
    pull = vectors * np.sqrt(np.maximum(values, 0)) @ rng.standard_normal((16, draws))
    error = np.zeros((16, draws))
    for _ in range(3):
        image: Floats = covariance @ (rows.T @ (noise[0] - slopes[0] @ error) - own)
        left: list[Floats] = [part - of_image @ image for part, of_image in zip(noise, seen, strict=True)]
        error = gain @ (sum(slope.T @ part for slope, part in zip(slopes, left, strict=True)) - pull)
    since = modes[-1] - modes[0]
    for axis, added in enumerate(stated):
        block = slice(8 * axis, 8 * axis + 8)
        assert added > 0.1 * since @ gain[block, block] @ since
        assert np.var(since @ error[block]) == pytest.approx(since @ gain[block, block] @ since + added, rel=0.08)


def test_what_the_final_image_would_still_change_counts_and_the_path_stays(iterate: Iterate) -> None:
    """A path that runs off by 0.4 px along x: the image asks it back, and what it asks is within sigma."""
    wrong_px = iterate.trajectory.displacement_px + np.outer(np.linspace(0, 0.4, FRAMES), [1.0, 0.0])
    right, wrong = (
        stated(_picture(iterate.along(replace(iterate.trajectory, displacement_px=path_px))), fitted=False)
        for path_px in (iterate.trajectory.displacement_px, wrong_px)
    )
    np.testing.assert_array_equal(wrong.displacement_px, wrong_px)
    assert wrong.sigma_px[-1, 0] == pytest.approx(np.hypot(right.sigma_px[-1, 0], 0.4), rel=0.3)
    assert wrong.sigma_px[-1, 1] == pytest.approx(right.sigma_px[-1, 1], rel=0.3)
    assert wrong.covariance is not None
    diagonal = np.diagonal(wrong.covariance.covariance_px2, axis1=1, axis2=2)
    np.testing.assert_allclose(diagonal.T, wrong.sigma_px[wrong.covariance.frame] ** 2, rtol=1e-6)
