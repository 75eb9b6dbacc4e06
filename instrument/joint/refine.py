"""Joint refinement of path and image: each is estimated in turn with the other held, until the path stands still."""

from dataclasses import dataclass, replace

import numpy as np

from instrument.choices import Background, Extent, Shape
from instrument.joint.background import background_of
from instrument.joint.changing import changing
from instrument.joint.detail import Picture, in_detail
from instrument.joint.evidence import CONTRADICTS
from instrument.joint.freedom import freedom_of
from instrument.joint.grid import grid_of
from instrument.joint.iterate import Iterate
from instrument.joint.lost_frame import LostFrame, lost_frame
from instrument.joint.rounds import FEWEST_FRAMES, Refinement, refined
from instrument.joint.stated import stated
from instrument.measurement import Measurement
from instrument.numerics import TvState, one_blas_thread
from instrument.reconstruction import Problem, Reconstruction, Region, light_for, solution_of
from instrument.recording import Recording
from instrument.schemes import position_of
from instrument.tracking import Trajectory, as_trajectory
from protocols import Floats, InputError
from protocols.field_docs import with_fields

_WORSE = 1.05  # ratio of misfits above which the refined path is worse than the one given
_MORE_PX = 4  # by which a wide image is larger while its path is refined: about by so much a path is corrected
_NO_BETTER = 1.01  # ratio of misfits above which smaller pixels explain less than those of the patterns do


@with_fields
@dataclass(frozen=True, eq=False)
class Refined:
    """Path and image that explain the values together."""

    trajectory: Trajectory
    """Displacement with its uncertainty, relative to ``reference_frame``."""

    image: Reconstruction
    """Image at the reference frame of the path."""

    refinements: int
    """Number of refinements of the path; 0 where the one given was kept."""

    measurement: Measurement
    """What was measured, corrected by the light model that the run determined."""

    position_misfit: float = np.nan
    """Root mean square of what image and path leave of the position values, over their noise, of the pattern where it is largest:
    far above 1 where position and image contradict each other. NaN where there are too few frames to refine."""

    usual_misfit: float = np.nan
    """Misfit of the image with the usual smoothing on the patterns' grid, before detail is looked for."""

    lost_frame: LostFrame | None = None
    """A frame that may be lost, as the image says; None where none is, or where position and image contradict each other."""


@one_blas_thread()
def refine(
    recording: Recording | Measurement,
    motion: Trajectory | Floats,
    *,
    region: Extent | Region = "inside",
    grid: int | None = 1,
    background: Background = "auto",
    fitted: bool = True,
    shape: Shape = "rigid",
) -> Refined:
    """Refine a trajectory and the light model by all that was measured, and reconstruct the image.

    Each refinement solves for the image with the path held (total variation, warm start), fits the free numbers of the light
    model to what the image leaves unexplained, and then makes one Gauss-Newton step of the path with the image held. The image
    predicts all values of every frame: those of the position patterns from the binary patterns as they act, so that dithering is
    no error any more, and the Hadamard difference. Each frame's step is weighted by its Fisher information, and the path is
    smoothed as far as the data allow. The final image is solved for without a warm start, as what earlier images invented with a
    worse path would persist.

    The stated uncertainty is that of the smoothed path, enlarged where the values show slow errors (``path_step``), by that of
    the image, which is estimated from the same values (``image_doubt``), by what one more step with the final image would change,
    and by that of offsets and uneven light. It does not cover a bend at the run's ends that is too weak for the data to show.

    Of an object that passes by (the region ``wide``, or one that reaches outside the field) the total light says where it is too,
    so that the lamp must be steady; no offsets are taken from the run beforehand, as a circle's centre is none where what is in
    the field changes; and ``auto`` looks for no background.

    Where the refined path explains the values worse than the one given, that one is kept: where the patterns are too alike, as
    in a plan that shows few of them in an unfavourable order, the image may mislead the path.

    Args:
        recording: recording of a scheme with position and image.
        motion: path to start from, right within about a pixel: what ``track`` gave.
        region: which pixels are solved for, as in ``reconstruct``.
        grid: image pixels that a pattern pixel has along each axis in the image that is returned; None takes 2 where motion and
            noise support it, else 1.
        fitted: whether leak, edge loss and offsets are fitted to the run. If not, the light model stays as it is.
        background: whether the light of something that stands still, and that nobody measured, is found too.
        shape: whether the object's turning and growing is found too: where the values show it (``auto``), always (``changing``).
            The path is then that of its centroid.

    Raises:
        InputError: as ``reconstruct``, the scheme has no position, or a changing shape is asked of an object that passes by.
    """
    measurement = light_for(recording, region)
    position_of(measurement.scheme)
    values = measurement.image_values(steady_object=region == "inside")
    trajectory = as_trajectory(motion, len(measurement), measurement.frame_time_s)
    problem = Problem.of(measurement, values, trajectory, region=region)
    if region == "wide":  # the path may prove longer
        problem = problem.within(problem.region.wider(_MORE_PX))
    if problem.passes and shape == "changing":
        raise InputError(
            saw="a changing shape of an object that passes by",
            expected="a rigid one: what turns and what comes into the field look alike",
            remedy="leave out the shape, or the region",
        )
    start: TvState | None = None
    if background == "fit":
        problem = problem.with_still()
    elif background == "auto" and len(values) >= FEWEST_FRAMES and not problem.passes:
        there, start = background_of(measurement, problem)
        problem = problem.with_still() if there else problem
    given = Iterate(measurement, problem, trajectory)
    refinement = refined(given, start, fitted=fitted)
    finer = grid or (1 if problem.passes else grid_of(refinement.iterate.trajectory, refinement.penalty))
    usual = Picture.of(_as_seen(refinement.iterate, region).on_grid(finer))
    if usual.state.misfit > _WORSE * refinement.misfit_given:
        usual = Picture.of(_as_seen(given, region).on_grid(finer))
    changed = None if shape == "rigid" or problem.passes else changing(usual, asked=shape == "changing", fitted=fitted)
    best = changed or (usual if usual.iterate.problem.passes else in_detail(usual, fitted=fitted))
    if changed is None and grid is None and finer > 1 and best.state.misfit > _NO_BETTER * refinement.misfit:
        best = in_detail(
            Picture.of(usual.iterate.on_grid(1)), fitted=fitted
        )  # smaller pixels should explain more, not less
    problem = best.iterate.problem
    image = Reconstruction.of(problem, solution_of(problem, best.state), "tv")
    freedom = freedom_of(best)
    image = replace(image, misfit=freedom.misfit, unknowns=freedom.unknowns)
    path = best.iterate.trajectory
    if problem.passes and best.iterate.refinements:
        # How errors of image and path feed each other over rounds is only known for the differences' rows: one round is stated.
        path = stated(replace(best, iterate=replace(best.iterate, refinements=1)), fitted=fitted)
    elif best.iterate.refinements:
        path = stated(best, fitted=fitted)
    return Refined(
        path,
        image,
        best.iterate.refinements,
        best.iterate.measurement,
        refinement.position_misfit,
        refinement.misfit,
        _lost_frame(refinement),
    )


def _lost_frame(refinement: Refinement) -> LostFrame | None:
    """Look for a frame that was lost, where path and image agree."""
    problem = refinement.iterate.problem
    if refinement.state is None or problem.passes or refinement.position_misfit > CONTRADICTS:
        return None
    return lost_frame(problem, refinement.state)


def _as_seen(iterate: Iterate, region: Extent | Region) -> Iterate:
    """Take the pixels that the field sees along the path found, where these were asked for."""
    if region != "wide":
        return iterate
    problem = iterate.problem
    return iterate.within(Region.seen(problem.places.every_px, problem.values.size))
