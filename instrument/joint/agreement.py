"""Whether the position values of a run are those of the object that its Hadamard values show."""

from instrument.joint.expected import Explained
from instrument.measurement import Measurement
from instrument.numerics import one_blas_thread
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
    return Explained.at_first_sight(measurement, trajectory).misfit()
