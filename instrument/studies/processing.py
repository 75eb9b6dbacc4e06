"""The two ways in which every run of a study is processed: as published, and by Kinopix's own analysis."""

from dataclasses import dataclass, replace
from typing import Final

from instrument.analysis import analyse
from instrument.choices import Method
from instrument.measurement import Measurement
from instrument.numerics import (
    displacement_mse,
    one_blas_thread,
    psnr,
    ssim_global,
    ssim_local,
    tv_augmented_lagrangian,
)
from instrument.reconstruction import METHODS, Places, Problem, Reconstruction, Solution
from instrument.recording import Recording
from instrument.tracking import Trajectory, as_trajectory, track
from protocols import Floats, InputError, Truth

MU: Final = 2.0**5
"""TVAL3's weight of the values in every image "as published". The paper prints none. Of the powers of 2 that TVAL3's guide
allows, 2^4 to 2^13, it is the one with which both methods of table 1 that follow the motion come nearest to the printed PSNR."""


@dataclass(frozen=True, eq=False)
class Outcome:
    """What one processing made of one run."""

    figures: dict[str, float]
    """Figures of merit by name, as in ``study.METRICS``; those that the run does not have are left out."""

    image: Floats
    """``(m, m)``: image at the patterns' resolution, at frame 0."""


@one_blas_thread()
def as_published(recording: Recording, *, mean_filter: int = 1, ghost: bool = False) -> Outcome:
    """Process a run as the paper does.

    The position of each frame is the phase of its own coefficients, against those of frame 0. Nothing is asked of the run about
    its light. Each frame has one displacement, and row k of the measurement matrix is the Hadamard pattern moved by it. The image
    of the whole field is TVAL3's, or the differential ghost image. A scheme without position gives the inverse transform, as if
    the object stood still.

    Args:
        recording: simulated run.
        mean_filter: number of neighbouring coefficients that are averaged: 5 where the paper fights noise, else 1.
        ghost: whether the image is the differential ghost image.
    """
    measurement = replace(Measurement.of(recording), light_found=True)
    values = measurement.image_values(steady_object=False)
    if measurement.scheme.position is None:
        whole = Problem.of(measurement, values, _at_rest(measurement), region="field")
        made = METHODS["conventional"].solve(whole, 0.0)
        return _outcome(recording, None, Reconstruction.of(whole, made, "conventional").image)
    path = track(measurement, "per-frame", mean_filter=mean_filter)
    problem = Problem.of(measurement, values, path, region="field")
    of_frame = path.displacement_px[values.frame]
    problem = replace(problem, places=Places(of_frame, of_frame, problem.places.fixed))
    if ghost:
        made = METHODS["dgi"].solve(problem, 0.0)
    else:
        state = tv_augmented_lagrangian(*problem.hadamard(), mu=MU)
        made = Solution(state.image, problem.region, state.misfit, state.iterations)
    return _outcome(recording, path, Reconstruction.of(problem, made, "dgi" if ghost else "tv-al").image)


def own(recording: Recording, method: Method = "tv") -> Outcome:
    """Process a run as ``kinopix analyse`` does by default, or with another image method on the path that it finds."""
    analysis = analyse(recording, method=method)
    if analysis.reconstruction is None:
        raise InputError(saw="a scheme without an image", expected="one with an image", remedy="take another scheme")
    return _outcome(recording, analysis.trajectory, analysis.reconstruction.at_patterns)


def _at_rest(measurement: Measurement) -> Trajectory:
    return as_trajectory(None, len(measurement), measurement.frame_time_s)


def _outcome(recording: Recording, path: Trajectory | None, image: Floats) -> Outcome:
    """Judge path and image by the truth. Photon counts have no scale, so that their images get one least-squares gain."""
    truth, fit_gain = _truth(recording), recording.photon_counts
    figures = {
        "psnr_db": psnr(image, truth.image, fit_gain=fit_gain),
        "ssim_global": ssim_global(image, truth.image, fit_gain=fit_gain),
        "ssim_local": ssim_local(image, truth.image, fit_gain=fit_gain),
    }
    if path is not None:
        figures = {"mse_px2": displacement_mse(path.displacement_px, truth.displacement_px), **figures}
    return Outcome(figures, image)


def _truth(recording: Recording) -> Truth:
    if recording.truth is None:
        raise InputError(saw="a recording without truth", expected="a simulated one", remedy="take the simulated bench")
    return recording.truth
