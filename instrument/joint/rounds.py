"""Rounds of refinement: image, light and path in turn, each with the others held, until the path stands still."""

from dataclasses import dataclass
from typing import Final

import numpy as np

from instrument.joint.evidence import evidence_of
from instrument.joint.iterate import Iterate
from instrument.joint.light_fit import fit_light
from instrument.joint.path_step import path_step
from instrument.joint.prediction import Predictor
from instrument.joint.shape_step import reshaped
from instrument.numerics import TvState
from instrument.reconstruction import METHODS, solved
from protocols import Floats

USUAL: Final = METHODS["tv"].strength or 0.0
"""Strength of the smoothing that suits most objects."""

FEWEST_FRAMES: Final = 64
"""Frames below which an image is too poor to refine a path."""

_MOST_REFINEMENTS = 8
_MOST_PASSING = 24  # of an object that passes by, whose image is long in coming
_LOST = 0.25  # of the field: a path corrected by more runs away; one ran to 144,000 px
_STANDS_STILL = 0.204  # change of the path over its uncertainty, both rms, below which it is taken as found
_ANOTHER = 1.0  # change of the shape over its uncertainty from which on the image is begun afresh


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
    superpixel = given.measurement.plan.superpixel
    most = _MOST_PASSING if given.problem.passes else _MOST_REFINEMENTS
    for refinements in range(1, most + 1):
        if refinements > 1 or state is None:
            cold = current.problem.passes or (current.problem.still and state is None)
            state = solved(
                current.problem,
                strength=strength,
                tolerance=0.01 if cold else 0.03,
                iterations=200 if cold else 40,
                start=state,
            )
        misfit, penalty = state.misfit, state.penalty
        misfit_given = misfit if refinements == 1 else misfit_given
        predictor = predictor.of_field(current.problem)
        still = state.images[1] if current.problem.still else None
        current = current.seen_as(state.image, still)
        prediction = predictor.predict(current.problem, state.image, still)
        light = current.measurement.light
        offset = np.zeros(prediction.values.shape[1])
        if fitted:
            fit = fit_light(current.problem, prediction, light, superpixel)
            current, offset = current.lit_by(fit.light), fit.offset
        evidence = evidence_of(current.problem, prediction, offset)
        position_misfit = evidence.misfit
        frame, shape_stands, afresh = current.problem.values.frame, True, False
        trajectory = current.trajectory
        if trajectory.pivot_px is not None:
            step = reshaped(evidence, frame, trajectory)
            evidence, trajectory, shape_stands = step.evidence, step.trajectory, step.over_sigma < _STANDS_STILL
            afresh = step.over_sigma > _ANOTHER
        trajectory = path_step(evidence, frame, trajectory).trajectory
        if given.problem.passes and _lost(trajectory.displacement_px - given.trajectory.displacement_px, given):
            return Refinement(given, misfit_given, misfit_given, penalty, position_misfit)
        change_px = trajectory.displacement_px - current.trajectory.displacement_px
        current = current.along(trajectory)
        state = None if afresh and refinements < most else state
        if shape_stands and np.mean(change_px**2) < _STANDS_STILL**2 * np.mean(trajectory.sigma_px**2):
            break
    if current.trajectory.pivot_px is not None and state is not None:
        current = current.seen_as(state.image, state.images[1] if current.problem.still else None)
    return Refinement(current, misfit_given, misfit, penalty, position_misfit, state)


def _lost(change_px: Floats, given: Iterate) -> bool:
    """Whether a path has come so far from where it began, ``(frames, 2)``, that it leads nowhere."""
    return float(np.abs(change_px).max()) > _LOST * given.problem.values.size
