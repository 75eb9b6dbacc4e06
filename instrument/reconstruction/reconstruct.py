"""From a recording and the object's motion to its sharp image."""

from dataclasses import dataclass
from typing import Any, Literal, TypeAlias

import numpy as np
from numpy.typing import DTypeLike, NDArray

from instrument.reconstruction.conventional import inverse_walsh
from instrument.reconstruction.dgi import ghost_image
from instrument.reconstruction.operator import Operator, ShiftedHadamard
from instrument.reconstruction.region import Region
from instrument.reconstruction.rows import NEGATIVE, POSITIVE, Measurement, as_trajectory, places_px
from instrument.reconstruction.tv import TvState, total_variation
from instrument.reconstruction.tval3 import AlState, tv_augmented_lagrangian
from instrument.recording import Recording
from instrument.schemes import scheme_of
from instrument.threads import one_blas_thread
from instrument.tracking import Trajectory
from protocols import Floats, Singles

Method: TypeAlias = Literal["tv", "tv-fourier", "tv-bregman", "tv-al", "dgi", "conventional"]

_STRENGTH = {"tv": 3.0, "tv-fourier": 3.0, "tv-bregman": 5.0}


@dataclass(frozen=True, eq=False)
class Reconstruction:
    """The image of the object where it was in frame 0. As an array it is ``image``."""

    image: Floats
    """``(image_size, image_size)``, row = y (down), column = x. Transmission 0 to 1 where values count lit pixels; of a photon
    counter, which has no absolute scale, the brightest pixel is 1."""

    method: str
    """How it was made."""

    gain: float
    """Value units (photons) for one pixel of ``image`` = 1 and one pattern; 1 where the image is on the values' own scale."""

    noise: float
    """Standard deviation of a single value, rms over frames, in its own units."""

    misfit: float
    """RMS of what the image leaves unexplained, over the noise: about 1 where motion and image are right."""

    iterations: int
    """Of the solver; 0 where there is none."""

    region: Region
    """Where the image may differ from 0."""

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]:  # noqa: FBT001  (numpy's own signature)
        """Give ``image``, as numpy asks for it."""
        return np.array(self.image, dtype=dtype, copy=copy)


@one_blas_thread()
def reconstruct(
    recording: Recording,
    motion: Trajectory | Floats,
    method: Method = "tv",
    *,
    region: bool = True,
    strength: float | None = None,
) -> Reconstruction:
    """Reconstruct the image at frame 0.

    Args:
        recording: of the six-pattern scheme. Frames that are not valid are left out.
        motion: what ``track`` gave, or ``(frames, 2)`` displacements (x, y) in px in the middle of each frame.
        method: ``tv``, least total variation with found edges freed; ``tv-fourier``, of the Fourier values too: their dithering
            sees the shape, which is worth up to 3 dB where the noise is weak, at three times the time; ``tv-bregman``, with a
            Bregman step instead of edges freed; ``tv-al``, TVAL3's model with its default weights, for comparison; ``dgi``,
            differential ghost imaging; ``conventional``, the inverse Hadamard transform, which ignores the motion.
        region: whether the object stays inside the field in every frame. Then only pixels it can occupy are solved for, and
            values are divided by the smoothed total light. Without it all pixels are, and the light is taken as steady.
        strength: of the smoothing, in units of the noise; None takes 3 for ``tv`` and 5 for ``tv-bregman``. Other
            methods have none.

    Raises:
        InputError: no valid frame, displacements of another shape, or a way too long for the field.
    """
    measurement = Measurement.of(recording, steady_object=region)
    places = places_px(as_trajectory(motion, recording), recording, measurement)
    size = measurement.size
    area = Region.inside(places.reshape(-1, 2), size) if region else Region.whole(size)
    if method == "dgi":
        return finished(measurement, area, _ghost(measurement, places, area), method)
    if method == "conventional":
        image = inverse_walsh(measurement.difference, measurement.pairs, size)
        return finished(measurement, Region.whole(size), image, method)
    rows: Operator
    if method == "tv-fourier":
        rows, values = measurement.with_fourier(scheme_of(recording.plan), places, area)
    else:
        rows, values = measurement.hadamard(places, area)
    if method == "tv-al":
        solved = tv_augmented_lagrangian(rows, values)
        return finished(measurement, area, solved.image, method, solved)
    strength = _STRENGTH[method] if strength is None else strength
    freed, steps = (0, 1) if method == "tv-bregman" else (None, 0)
    state = total_variation(rows, values, strength=strength, reweightings=freed, bregman_steps=steps)
    return finished(measurement, area, state.image, method, state)


def finished(
    measurement: Measurement, area: Region, part: Floats | Singles, method: str, state: TvState | AlState | None = None
) -> Reconstruction:
    """Put the image of a region on the whole field and on its scale."""
    image = area.paste(part.astype(np.float64), measurement.size)
    gain = float(image.max()) if measurement.photon_counts and image.max() > 0 else 1.0
    return Reconstruction(
        image=image / gain,
        method=method,
        gain=gain,
        noise=float(np.sqrt(np.mean(measurement.variance))),
        misfit=float("nan") if state is None else state.misfit,
        iterations=0 if state is None else state.iterations,
        region=area,
    )


def _ghost(measurement: Measurement, places: Floats, area: Region) -> Floats:
    """Differential ghost image of both patterns of each pair, with the gain that explains the differences best."""
    pairs, size = measurement.pairs, measurement.size
    image = np.zeros(area.shape)
    lit = np.where((pairs == 0).all(axis=1), size**2, size**2 / 2)
    for column, sign, pattern_sum in ((POSITIVE, 1.0, lit), (NEGATIVE, -1.0, size**2 - lit)):
        terms = np.stack([np.zeros_like(pairs), pairs])  # (1 + H) / 2, (1 - H) / 2
        patterns = ShiftedHadamard.of([0.5, 0.5 * sign], terms, np.stack([places[:, column]] * 2), size, area)
        values = measurement.values[:, column].astype(np.float32)
        image += ghost_image(patterns, values, pattern_sum.astype(np.float32))
    rows, values = measurement.hadamard(places, area)
    explained = rows.matvec(image.astype(np.float32).ravel())
    power = float(np.vdot(explained, explained))
    return image * (float(np.vdot(explained, values)) / power if power > 0 else 0.0)
