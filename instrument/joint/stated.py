"""The uncertainty that a refined path is told with: of the noise that its smoothing lets through, and of all that was estimated.

The path itself stays as it is. How far one more step would go with the final image, which is finer and was begun afresh, counts
as an error of its own: so far the path hangs on how the image was made.
"""

from dataclasses import replace

import numpy as np

from instrument.joint.detail import Picture
from instrument.joint.doubtful import of_offsets, of_uneven_light
from instrument.joint.evidence import evidence_of
from instrument.joint.image_doubt import by_image_px2
from instrument.joint.light_fit import fit_light
from instrument.joint.path_step import path_step
from instrument.joint.prediction import Predictor
from instrument.joint.shape_step import reshaped
from instrument.measurement import Measurement
from instrument.reconstruction import Problem
from instrument.tracking import PathCovariance, Trajectory
from protocols import Floats, Singles


def stated(picture: Picture, *, fitted: bool) -> Trajectory:
    """Give a refined path with the uncertainty that it is told with.

    Args:
        picture: path, and the final image along it.
        fitted: whether the light model was fitted to the run.
    """
    iterate, image = picture.iterate, picture.state.image
    problem, last = iterate.problem, iterate.trajectory
    frame = problem.values.frame
    still = picture.state.images[1] if problem.still else None
    prediction = Predictor.of(problem).predict(problem, image, still)
    count = prediction.values.shape[1]
    offset, uncertain = np.zeros(count), np.zeros((count, count))
    if fitted:
        fit = fit_light(problem, prediction, iterate.measurement.light, iterate.measurement.plan.superpixel)
        offset, uncertain = fit.offset, fit.offset_covariance
    evidence = evidence_of(problem, prediction, offset)
    if last.pivot_px is not None:
        evidence = reshaped(evidence, frame, last).evidence
    step = path_step(evidence, frame, last)
    if not step.fits:
        return last
    further_px = step.trajectory.displacement_px - last.displacement_px
    beside_px2 = (
        further_px**2
        + by_image_px2(picture, evidence, prediction, step.fits)
        + of_offsets(evidence, uncertain, frame, last)
        + _of_uneven_light(iterate.measurement, problem, last, image)
    )
    sigma_px = np.sqrt(step.trajectory.sigma_px**2 + beside_px2) * iterate.measurement.student_ratio
    return replace(last, sigma_px=sigma_px, covariance=PathCovariance.of(step.fits, sigma_px, last.reference_frame))


def _of_uneven_light(measurement: Measurement, problem: Problem, path: Trajectory, image: Singles) -> Floats:
    """``(frames, 2)``: variance by light of which nobody knows whether the lamp or the field changes it."""
    if problem.profile is not None or not problem.steady:
        return np.zeros((len(measurement), 2))
    total = np.where(measurement.valid, measurement.total, np.nan)
    return of_uneven_light(total, path, image, problem.field.grid)
