"""Joint refinement of path and image: each is estimated in turn with the other held, until the path stands still."""

from dataclasses import dataclass, replace

import numpy as np

from instrument.choices import Background
from instrument.joint.background import background_of
from instrument.joint.evidence import Evidence, View, evidence_of
from instrument.joint.grid import grid_of
from instrument.joint.light_fit import fit_light
from instrument.joint.prediction import Predictor
from instrument.measurement import LightModel, Measurement, first_light
from instrument.numerics import Smooth, TvState, one_blas_thread, smooth, total_variation
from instrument.reconstruction import Problem, Reconstruction, solution_of
from instrument.recording import Recording
from instrument.schemes import position_of
from instrument.tracking import PathCovariance, Trajectory, as_trajectory
from protocols import Floats, Integers

_FEWEST_FRAMES = 64  # below which an image is too poor to refine a path
_MOST_REFINEMENTS = 8
_LEAST_INFORMATION = 1e-3  # over the best frame's: a frame with less information makes a smaller step of its own
_BLOCK_FRAMES = (
    50  # in a block of which slow errors are seen: some pixels of path, longer than an error of the dithering
)
_BLOCKS = (8, 32)  # fewest and most blocks in a run
_WORSE = 1.05  # ratio of misfits above which the refined path is worse than the one given
_NO_BETTER = 1.01  # ratio of misfits above which smaller pixels explain less than those of the patterns do
_STANDS_STILL = 0.2  # change of the path over its uncertainty, both rms, below which it is taken as found
_TINY = 1e-12


@dataclass(frozen=True, eq=False)
class Refined:
    """Path and image that explain the values together."""

    trajectory: Trajectory
    """Displacement with its uncertainty, relative to frame 0."""

    image: Reconstruction
    """Image at frame 0."""

    refinements: int
    """Number of refinements of the path; 0 where the one given was kept."""

    measurement: Measurement
    """What was measured, corrected by the light model that the run determined."""


@dataclass(frozen=True, eq=False)
class _Iterate:
    """A path and a light model, and the image problem that they state."""

    measurement: Measurement
    """What was measured, corrected by the light model."""

    problem: Problem
    """Image values, and the displacement during each pattern."""

    trajectory: Trajectory
    """The path."""

    refinements: int = 0
    """Number of refinements that led to it."""

    def lit_by(self, light: LightModel) -> "_Iterate":
        """Correct the values by another light model."""
        if light == self.measurement.light:
            return self
        measurement = self.measurement.lit_by(light)
        return replace(self, measurement=measurement, problem=self.problem.remeasured(measurement))

    def along(self, trajectory: Trajectory) -> "_Iterate":
        """Take another path."""
        return replace(
            self, problem=self.problem.moved(trajectory), trajectory=trajectory, refinements=self.refinements + 1
        )


@one_blas_thread()
def refine(
    recording: Recording | Measurement,
    motion: Trajectory | Floats,
    *,
    region: bool = True,
    grid: int | None = 1,
    background: Background = "auto",
    fitted: bool = True,
) -> Refined:
    """Refine a trajectory and the light model by all that was measured, and reconstruct the image.

    Each refinement solves for the image with the path held (total variation, warm start), fits the free numbers of the light
    model to what the image leaves unexplained, and then makes one Gauss-Newton step of the path with the image held. The image
    predicts all values of every frame: those of the position patterns from the binary patterns as they act, so that dithering is
    no error any more, and the Hadamard difference. Each frame's step is weighted by its Fisher information, and the path is
    smoothed as far as the data allow. The final image is solved for without a warm start, as what earlier images invented with a
    worse path would persist.

    The stated uncertainty is that of the smoothed path, enlarged where the image leaves slow errors in the position values: they
    are seen in the amplitude of the signal, which no motion changes, and count in proportion to these values' share in the
    information. Where a position has no amplitude, as a centroid, they are seen in the steps that the Hadamard values still ask
    for. The uncertainty does not cover a bend at the ends of the run that is too weak for the data to show.

    Where the refined path explains the values worse than the one given, that one is kept: where the patterns are too alike, as
    in a plan that shows few of them in an unfavourable order, the image may mislead the path.

    Args:
        recording: recording of a scheme with position and image.
        motion: path to start from, right within about a pixel: what ``track`` gave.
        region: whether the object stays inside the field, as in ``reconstruct``.
        grid: image pixels that a pattern pixel has along each axis in the image that is returned; None takes 2 where motion and
            noise support it, else 1.
        fitted: whether leak, edge loss and offsets are fitted to the run. If not, the light model stays as it is.
        background: whether the light of something that stands still, and that nobody measured, is found too.

    Raises:
        InputError: as ``reconstruct``, or the scheme has no position.
    """
    measurement = first_light(recording)
    position_of(measurement.scheme)
    values = measurement.image_values(steady_object=region)
    trajectory = as_trajectory(motion, len(measurement), measurement.frame_time_s)
    problem = Problem.of(measurement, values, trajectory, inside=region)
    start: TvState | None = None
    if background == "fit":
        problem = problem.with_still()
    elif background == "auto" and len(values) >= _FEWEST_FRAMES:
        there, start = background_of(measurement, problem)
        problem = problem.with_still() if there else problem
    given = _Iterate(measurement, problem, trajectory)
    refinement = _refined(given, start, fitted=fitted)
    best = refinement.iterate
    finer = grid or grid_of(best.trajectory, refinement.penalty)
    state = _image_of(best, finer)
    if grid is None and finer > 1 and state.misfit > _NO_BETTER * refinement.misfit:
        finer = 1  # smaller pixels should explain more, not less
        state = _image_of(best, finer)
    if state.misfit > _WORSE * refinement.misfit_given:
        best = given
        state = _image_of(given, finer)
    final = best.problem.on_grid(finer)
    image = Reconstruction.of(final, solution_of(final, state), "tv")
    return Refined(best.trajectory, image, best.refinements, best.measurement)


def _image_of(iterate: _Iterate, grid: int) -> TvState:
    """Solve for the image, with the path held."""
    problem = iterate.problem.on_grid(grid)
    return total_variation(*problem.hadamard(), finer=problem.finer)


@dataclass(frozen=True, eq=False)
class _Refinement:
    """What refining led to."""

    iterate: _Iterate
    """The last iterate."""

    misfit_given: float = np.inf
    """Misfit with the path given."""

    misfit: float = np.inf
    """Misfit of the last image on the patterns' grid."""

    penalty: float = np.inf
    """How strong the noise is, as ``TvState.penalty`` says."""


def _refined(given: _Iterate, state: TvState | None, *, fitted: bool) -> _Refinement:
    """Refine path and light until they stand still."""
    if len(given.problem.values) < _FEWEST_FRAMES:
        return _Refinement(given)
    current, misfit_given, misfit, penalty = given, np.inf, np.inf, np.inf
    predictor = Predictor.of(given.problem)
    superpixel = given.measurement.plan.superpixel
    for refinements in range(1, _MOST_REFINEMENTS + 1):
        if refinements > 1 or state is None:
            cold = current.problem.still and state is None
            state = total_variation(
                *current.problem.hadamard(),
                tolerance=0.01 if cold else 0.03,
                iterations=200 if cold else 40,
                start=state,
            )
        misfit, penalty = state.misfit, state.penalty
        misfit_given = misfit if refinements == 1 else misfit_given
        predictor = predictor.of_field(current.problem)
        still = state.images[1] if current.problem.still else None
        prediction = predictor.predict(current.problem, state.image, still)
        light = current.measurement.light
        offset = np.zeros(prediction.values.shape[1])
        if fitted:
            fit = fit_light(current.problem, prediction, light, superpixel)
            current, offset = current.lit_by(fit.light), fit.offset
        evidence = evidence_of(current.problem, prediction, offset)
        trajectory = _gauss_newton_step(evidence, current.problem.values.frame, current.trajectory)
        change_px = trajectory.displacement_px - current.trajectory.displacement_px
        current = current.along(trajectory)
        if np.mean(change_px**2) < _STANDS_STILL**2 * np.mean(trajectory.sigma_px**2):
            break
    return _Refinement(current, misfit_given, misfit, penalty)


def _gauss_newton_step(evidence: Evidence, frame: Integers, last: Trajectory) -> Trajectory:
    """Make one Gauss-Newton step for x and then, with that made, one for y, each smoothed over the whole run.

    The Fisher information of a frame is the sum of its squared slopes, and its score that of slope times residual, as both are
    in units of the noise.

    Args:
        evidence: residuals and slopes at the last path.
        frame: ``(rows,)`` index of each valid frame.
        last: the path so far.
    """
    step_px = np.zeros((len(frame), 2))
    fits: list[Smooth] = []
    inflation: list[float] = []
    for axis in range(2):
        last_px = last.displacement_px[:, axis]
        information, score = np.zeros(len(last)), np.zeros(len(last))
        for view in evidence.views:
            residual = view.residual - np.vecdot(view.slope, step_px)
            information[frame] += view.slope[:, axis] ** 2
            score[frame] += view.slope[:, axis] * residual
        target_px = last_px + score / np.maximum(information, _LEAST_INFORMATION * information.max())
        fit = smooth(target_px, information, absolute_weights=True)
        step_px[:, axis] = (fit.values - last_px)[frame]
        fits.append(fit)
        own = evidence.axes[axis]
        share = float(np.sum(own.position.slope[:, axis] ** 2) / information.sum())
        if own.amplitude is not None:
            inflation.append(1 + share * (_slow_error_ratio(own.amplitude) - 1))
        else:
            inflation.append(1 + (1 - share) * (_slow_step_ratio(evidence.hadamard, axis) - 1))
    place_px = np.stack([fit.values for fit in fits], axis=1)
    variance_px2 = np.stack([fit.variance_to_first for fit in fits], axis=1) * np.array(inflation)
    sigma_px = np.sqrt(variance_px2)
    covariance = PathCovariance.of(fits, sigma_px)
    return replace(
        last, displacement_px=place_px - place_px[0], sigma_px=sigma_px, method="joint", covariance=covariance
    )


def _slow_error_ratio(amplitude: Floats) -> float:
    """Give the variance of an amplitude's means over blocks, relative to that of white noise of variance 1; at least 1."""
    blocks = _in_blocks(amplitude)
    frames = int(blocks.shape[1])
    return max(1.0, float(blocks.mean(axis=1).var(ddof=1)) * frames)


def _slow_step_ratio(view: View, axis: int) -> float:
    """Give the variance of the step that each block of frames asks for along an axis, relative to that of its noise; at least 1.

    Where path and image are right, the residuals are noise, and each block asks for a step as large as its information allows:
    the square of the step over its variance is 1 in the mean (a reduced chi-square over blocks).
    """
    slope = view.slope[:, axis]
    score: Floats = _in_blocks(slope * view.residual).sum(axis=1)
    information: Floats = _in_blocks(slope**2).sum(axis=1)
    return max(1.0, float(np.mean(score**2 / np.maximum(information, _TINY))))


def _in_blocks(series: Floats) -> Floats:
    """``(blocks, frames)``: a series cut into blocks in which errors are slow; what is left at its end is left out."""
    fewest, most = _BLOCKS
    frames = max(2, len(series) // min(max(len(series) // _BLOCK_FRAMES, fewest), most))
    return series[: len(series) // frames * frames].reshape(-1, frames)
