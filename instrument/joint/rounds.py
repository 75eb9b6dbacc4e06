"""Rounds of refinement: image, light and path in turn, each with the others held, until the path stands still."""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from instrument.joint.doubtful import of_offsets, of_uneven_light, widened
from instrument.joint.evidence import Evidence, View, evidence_of
from instrument.joint.iterate import Iterate
from instrument.joint.light_fit import fit_light
from instrument.joint.prediction import Predictor
from instrument.joint.shape_step import reshaped
from instrument.numerics import Smooth, TvState, smooth, total_variation
from instrument.reconstruction import METHODS
from instrument.tracking import PathCovariance, Trajectory
from protocols import Floats, Integers, Singles

USUAL: Final = METHODS["tv"].strength or 0.0
"""Strength of the smoothing that suits most objects."""

FEWEST_FRAMES: Final = 64
"""Frames below which an image is too poor to refine a path."""

_MOST_REFINEMENTS = 8
_LEAST_INFORMATION = 1e-3  # over the best frame's: a frame with less information makes a smaller step of its own
_BLOCK_FRAMES = (
    50  # in a block of which slow errors are seen: some pixels of path, longer than an error of the dithering
)
_BLOCKS = (8, 32)  # fewest and most blocks in a run
_STANDS_STILL = 0.2  # change of the path over its uncertainty, both rms, below which it is taken as found
_OF_STILL = 4.0  # variance of the offsets over that of the fit where an image of what stands still is found too
_TAKEN_BY_IMAGE = 0.2
"""Share of what the Hadamard values say of a slow motion that goes into the image instead: it bends as the path does. Measured
for letter, plane and bars, as the share of such a motion's values that the solver's image follows: 0.1 to 0.25."""
_ANOTHER = 1.0  # change of the shape over its uncertainty from which on the image is begun afresh
_TINY = 1e-12


@dataclass(frozen=True, eq=False)
class Refinement:
    """What refining led to."""

    iterate: Iterate
    """The last iterate."""

    misfit_given: float = np.inf
    """Misfit with the path given."""

    misfit: float = np.inf
    """Misfit of the last image on the patterns' grid."""

    penalty: float = np.inf
    """How strong the noise is, as ``TvState.penalty`` says."""

    position_misfit: float = np.nan
    """Misfit of the position values, as ``Evidence.misfit`` says, with the last image."""

    state: TvState | None = None
    """The last image; None where there are too few frames for one."""


def refined(
    given: Iterate,
    state: TvState | None,
    *,
    fitted: bool,
    strength: float = USUAL,
) -> Refinement:
    """Refine path and light until they stand still.

    Args:
        given: path and light to start from, and the problem on the grid of the images that refine them.
        state: image of that problem to start from; None for none.
        fitted: whether the light model is fitted to the run.
        strength: strength of the smoothing of these images.
    """
    if len(given.problem.values) < FEWEST_FRAMES:
        return Refinement(given)
    current, misfit_given, misfit, penalty, position_misfit = given, np.inf, np.inf, np.inf, np.nan
    predictor = Predictor.of(given.problem)
    beside_px2, image = np.zeros((len(given.trajectory), 2)), np.zeros((1, 1), np.float32)
    superpixel = given.measurement.plan.superpixel
    for refinements in range(1, _MOST_REFINEMENTS + 1):
        if refinements > 1 or state is None:
            cold = current.problem.still and state is None
            state = total_variation(
                *current.problem.hadamard(),
                strength=strength,
                finer=current.problem.finer,
                tolerance=0.01 if cold else 0.03,
                iterations=200 if cold else 40,
                start=state,
            )
        misfit, penalty = state.misfit, state.penalty
        misfit_given = misfit if refinements == 1 else misfit_given
        image = state.image
        predictor = predictor.of_field(current.problem)
        still = state.images[1] if current.problem.still else None
        current = current.seen_as(state.image, still)
        prediction = predictor.predict(current.problem, state.image, still)
        light = current.measurement.light
        count = prediction.values.shape[1]
        offset, uncertain = np.zeros(count), np.zeros((count, count))
        if fitted:
            fit = fit_light(current.problem, prediction, light, superpixel)
            current, offset, uncertain = current.lit_by(fit.light), fit.offset, fit.offset_covariance
        evidence = evidence_of(current.problem, prediction, offset)
        position_misfit = evidence.misfit
        frame, shape_stands, afresh = current.problem.values.frame, True, False
        trajectory = current.trajectory
        if trajectory.pivot_px is not None:
            step = reshaped(evidence, frame, trajectory)
            evidence, trajectory, shape_stands = step.evidence, step.trajectory, step.over_sigma < _STANDS_STILL
            afresh = step.over_sigma > _ANOTHER
        trajectory = _gauss_newton_step(evidence, frame, trajectory)
        change_px = trajectory.displacement_px - current.trajectory.displacement_px
        current = current.along(trajectory)
        if current.problem.still:  # what stands still gives the position values offsets, which its image hardly tells
            beside_px2 = of_offsets(evidence, _OF_STILL * uncertain, frame, len(trajectory))
        state = None if afresh and refinements < _MOST_REFINEMENTS else state
        if shape_stands and np.mean(change_px**2) < _STANDS_STILL**2 * np.mean(trajectory.sigma_px**2):
            break
    if current.trajectory.pivot_px is not None and state is not None:
        current = current.seen_as(state.image, state.images[1] if current.problem.still else None)
    beside_px2 = beside_px2 + _of_uneven_light(current, image)
    sure = widened(current.trajectory, beside_px2, current.measurement.student_ratio)
    current = replace(current, trajectory=sure)
    return Refinement(current, misfit_given, misfit, penalty, position_misfit, state)


def _of_uneven_light(current: Iterate, image: Singles) -> Floats:
    """``(frames, 2)``: variance by light of which nobody knows whether the lamp or the field changes it."""
    measurement, problem = current.measurement, current.problem
    if problem.profile is not None or not problem.steady:
        return np.zeros((len(measurement), 2))
    total = np.where(measurement.valid, measurement.total, np.nan)
    return of_uneven_light(total, current.trajectory, image, problem.field.grid)


def _gauss_newton_step(evidence: Evidence, frame: Integers, last: Trajectory) -> Trajectory:
    """Make one Gauss-Newton step for x and then, with that made, one for y, each smoothed over the whole run.

    The Fisher information of a frame is the sum of its squared slopes, and its score that of slope times residual, as both are
    in units of the noise.

    Args:
        evidence: residuals and slopes at the last path.
        frame: ``(rows,)`` index of each valid frame.
        last: the path so far.

    Returns:
        The refined path; the last one where the image is too dark to say anything of it.
    """
    step_px = np.zeros((len(frame), 2))
    fits: list[Smooth] = []
    inflation: list[float] = []
    for axis in range(2):
        last_px = last.displacement_px[:, axis]
        information, score = np.zeros(len(last)), np.zeros(len(last))
        for view in evidence.views:
            residual = view.residual - np.vecdot(view.slope[:, :2], step_px)
            information[frame] += view.slope[:, axis] ** 2
            score[frame] += view.slope[:, axis] * residual
        if not (information > 0).any():
            return last  # nothing is to be seen along this axis
        target_px = last_px + score / np.maximum(information, _LEAST_INFORMATION * information.max())
        fit = smooth(target_px, information, absolute_weights=True)
        step_px[:, axis] = (fit.values - last_px)[frame]
        fits.append(fit)
        own = evidence.axes[axis]
        share = float(np.sum(own.position.slope[:, axis] ** 2) / information.sum())
        amplitude, steps = 1.0, _slow_step_ratio(evidence.hadamard, axis)
        if own.amplitude is not None:  # which tells already, so that here only what is no chance counts
            amplitude = _slow_error_ratio(own.amplitude)
            steps = max(1.0, steps - (2 / len(_in_blocks(own.amplitude))) ** 0.5)
        lost = 1 - _TAKEN_BY_IMAGE * (1 - share)
        inflation.append((1 + share * (amplitude - 1) + (1 - share) * (steps - 1)) / lost)
    place_px = np.stack([fit.values for fit in fits], axis=1)
    origin = last.reference_frame
    variance_px2 = np.stack([fit.variance_to(origin) for fit in fits], axis=1) * np.array(inflation)
    sigma_px = np.sqrt(variance_px2)
    covariance = PathCovariance.of(fits, sigma_px, origin)
    return replace(
        last, displacement_px=place_px - place_px[origin], sigma_px=sigma_px, method="joint", covariance=covariance
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
