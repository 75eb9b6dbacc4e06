"""Whether the position values of a run are those of the object that its Hadamard values show."""

import numpy as np

from instrument.joint.evidence import evidence_of
from instrument.joint.prediction import Predictor
from instrument.joint.rounds import USUAL
from instrument.measurement import Measurement
from instrument.numerics import one_blas_thread, total_variation
from instrument.reconstruction import Problem
from instrument.tracking import Trajectory


@one_blas_thread()
def position_misfit(measurement: Measurement, trajectory: Trajectory) -> float:
    """Give the misfit of the position values, as ``Refined.position_misfit`` says, with one image along a path as it is.

    Args:
        measurement: of the run, its light found.
        trajectory: the path.

    Raises:
        InputError: the displacements leave no room for an object in the field.
    """
    problem = Problem.of(measurement, measurement.image_values(steady_object=True), trajectory, inside=True)
    state = total_variation(
        *problem.hadamard(), strength=USUAL, finer=problem.finer, tolerance=0.03, iterations=40, reweightings=0
    )
    prediction = Predictor.of(problem).predict(problem, state.image, None)
    return evidence_of(problem, prediction, np.zeros(len(prediction.values.T))).misfit
