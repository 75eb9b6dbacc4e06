"""Joint refinement: the path from all values against the current image, the image again with that path, until both stand."""

from dataclasses import dataclass

import numpy as np

from instrument.joint.evidence import Evidence, evidence
from instrument.measurement import Measurement
from instrument.numerics import Smooth, TvState, one_blas_thread, smooth, total_variation
from instrument.reconstruction import Problem, Reconstruction, Solution
from instrument.recording import Recording
from instrument.schemes import position_of
from instrument.tracking import Trajectory, as_trajectory
from protocols import Floats, Integers

_FEWEST = 64  # frames below which an image is too poor to refine anything
_LEAST_INFORMATION = 1e-3  # of the best frame's: a frame that tells less makes no step of its own
_BLOCKS = (8, 32)  # of a run, to see slow errors in: fewest and most
_BLOCK = 50  # frames in one of them: some pixels of distance, longer than dithering keeps its error
_WORSE = 1.05  # times the misfit of the path given: a refined one that explains the values worse than that is dropped
_STANDS = 0.2  # of the uncertainty: a change of the path below that is none


@dataclass(frozen=True, eq=False)
class Refined:
    """Path and image that explain the values together."""

    trajectory: Trajectory
    """Displacement with its uncertainty, relative to frame 0."""

    image: Reconstruction
    """Image at frame 0."""

    refinements: int
    """How often the path was refined; 0 where the one given was kept."""


@one_blas_thread()
def refine(
    recording: Recording | Measurement, motion: Trajectory | Floats, *, region: bool = True, loops: int = 8
) -> Refined:
    """Refine a trajectory by all that was measured, and reconstruct the image.

    Each loop solves for the image (warm start), predicts all values of every frame with it, those of the position patterns from
    the binary patterns as shown (so that dithering is no error any more) and the Hadamard difference, and makes one Gauss-Newton
    step for the whole path: each frame's displacement that would explain its values best, weighted by its information,
    smoothed as far as the data say. The last image starts anew: what earlier ones invented, with a worse path, would stay.

    The stated uncertainty is the smoother's, and more where the image leaves slow errors in the position values: they are seen
    in the amplitude, in which there is no motion, and count in proportion to what these values tell of the motion. It does not
    know of a bend at the run's ends too weak for the data to show.

    Where the refined path explains the values worse than the one given, that one is kept: patterns too alike, of a plan that
    shows few of them in an unlucky order, make an image that leads astray.

    Args:
        recording: of a scheme with position and image.
        motion: where to start, within about a pixel: what ``track`` gave.
        region: as in ``reconstruct``.
        loops: at most so many. It ends earlier where the path changes by less than a fifth of its uncertainty.

    Raises:
        InputError: as ``reconstruct``, or a scheme without position.
    """
    measurement = Measurement.of(recording)
    position_of(measurement.scheme)
    values = measurement.image_values(steady_object=region)
    given = as_trajectory(motion, len(measurement), measurement.frame_time_s)
    first = Problem.of(measurement, values, given, inside=region)
    problem, trajectory = first, given
    fixed = first.fixed_patterns()
    total: Floats = values.positive + values.negative
    if len(total) >= _FEWEST:
        total = smooth(total, np.ones(len(total)), orders=(1,)).values
    first_misfit: float | None = None
    state: TvState | None = None
    refinements = 0
    while len(values) >= _FEWEST and refinements < loops:
        state = total_variation(*problem.hadamard(), tolerance=0.03, iterations=40, start=state)
        first_misfit = state.misfit if first_misfit is None else first_misfit
        before = trajectory
        trajectory = _step(evidence(problem, fixed, total, state.image), values.frame, trajectory)
        problem = problem.moved(trajectory)
        refinements += 1
        change = trajectory.displacement_px - before.displacement_px
        if np.mean(change**2) < _STANDS**2 * np.mean(trajectory.sigma_px**2):
            break
    state = total_variation(*problem.hadamard())
    if first_misfit is not None and state.misfit > _WORSE * first_misfit:
        problem, trajectory, refinements = first, given, 0
        state = total_variation(*first.hadamard())
    solution = Solution(state.image, problem.region, state.misfit, state.iterations)
    return Refined(trajectory, Reconstruction.of(problem, solution, "tv"), refinements)


def _step(found: Evidence, frame: Integers, last: Trajectory) -> Trajectory:
    """Make one Gauss-Newton step for x, then for y, each smoothed over the whole run.

    Args:
        found: what the values say at the last path.
        frame: ``(rows,)`` index of each valid frame.
        last: the path so far.
    """
    path = last.displacement_px
    moved = np.zeros((len(frame), 2))
    fits: list[Smooth] = []
    excess: list[float] = []
    for axis in range(2):
        information, score = np.zeros(len(path)), np.zeros(len(path))
        for view in found.views:
            left = view.residual - np.vecdot(view.slope, moved)
            information[frame] += view.slope[:, axis] ** 2
            score[frame] += view.slope[:, axis] * left
        wanted = path[:, axis] + score / np.maximum(information, _LEAST_INFORMATION * information.max())
        fit = smooth(wanted, information, absolute_weights=True)
        moved[:, axis] = (fit.values - path[:, axis])[frame]
        fits.append(fit)
        own = found.axes[axis]
        share = float(np.sum(own.position.slope[:, axis] ** 2) / information.sum())
        excess.append(1 + share * (_slowness(own.amplitude) - 1))
    place_px = np.stack([fit.values for fit in fits], axis=1)
    variance = np.stack([fit.variance_to_first for fit in fits], axis=1) * np.array(excess)
    return Trajectory(place_px - place_px[0], np.sqrt(variance), last.frame_time_s, "joint", last.valid)


def _slowness(amplitude: Floats | None) -> float:
    """Power of slow errors in an amplitude, over that of white noise of variance 1; at least 1, and 1 without an amplitude."""
    if amplitude is None:
        return 1.0
    block = max(2, len(amplitude) // min(max(len(amplitude) // _BLOCK, _BLOCKS[0]), _BLOCKS[1]))
    means = amplitude[: len(amplitude) // block * block].reshape(-1, block).mean(axis=1)
    return max(1.0, float(means.var(ddof=1)) * block)
