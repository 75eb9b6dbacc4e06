"""How the image of a run forms: made from more and more of its frames, on the path that the whole run gave."""

from collections.abc import Generator
from dataclasses import dataclass, replace

import numpy as np

from instrument.analysis.analyse import Analysis
from instrument.reconstruction import method_of, reconstruct
from instrument.tracking import Trajectory
from protocols import Floats, InputError

_FEWEST_FRAMES = 8
"""Frames of the first image at least: with fewer there is nothing to solve."""


@dataclass(frozen=True, eq=False)
class Stage:
    """The image after some of the frames."""

    frames: int
    """Number of frames, from the first on."""

    image: Floats
    """``(grid m, grid m)``, or larger as ``Reconstruction.image`` says: the image from these frames."""


def forming(analysis: Analysis, stages: int) -> Generator[Stage]:
    """Give the image from the first frames, evenly more of them at each stage; the last one is the image of the analysis.

    Light and path are those that the whole run gave, so that each stage costs a reconstruction and no search.

    Args:
        analysis: analysis of the whole run.
        stages: number of images, at least 2; fewer where the run has fewer frames.

    Raises:
        InputError: the scheme gives no path or no image, or fewer than 2 stages are asked for.
    """
    path, whole = analysis.trajectory, analysis.reconstruction
    if path is None or whole is None:
        raise InputError(
            saw="a recording whose scheme gives no path or no image",
            expected="a recording of a scheme that does both",
            remedy='record with another scheme, such as "fourier-hadamard"',
        )
    if stages < 2:
        raise InputError(saw=f"{stages} pictures", expected="at least 2", remedy="ask for more")
    total = len(path)
    counts = np.unique(np.linspace(min(_FEWEST_FRAMES, total), total, stages).round().astype(np.int64)).tolist()
    finer = method_of(whole.method).finer
    for frames in counts[:-1]:
        image = reconstruct(
            analysis.measurement.first(frames),
            _beginning(path, frames),
            "tv",
            region=whole.region if whole.wide else "inside",
            grid=whole.grid if finer else 1,
            still=whole.still is not None,
        ).image
        yield Stage(frames, image)
    yield Stage(total, whole.image)


def _beginning(path: Trajectory, frames: int) -> Trajectory:
    return replace(
        path,
        displacement_px=path.displacement_px[:frames],
        sigma_px=path.sigma_px[:frames],
        valid=path.valid[:frames],
    )
