"""What the ramps of the first frames say of the object's position at frame 0."""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import shift

from instrument.measurement import Measurement
from instrument.schemes import Ramps
from instrument.tracking.trajectory import Trajectory
from protocols import Floats, Integers


@dataclass(frozen=True, eq=False)
class SeenStart:
    """Positions at frame 0 along one axis, as some frames see it; all ``(n,)``."""

    frame: Integers
    """Index of the frame."""

    place_px: Floats
    """Position at frame 0."""

    variance_px2: Floats
    """Its variance by the noise of the values."""

    def mean(self, displacement_sigma_px: Floats) -> tuple[float, float]:
        """Give the mean position, weighted by its certainty, and its standard deviation.

        Dithering makes a frame's position worse than the noise of its values does: where the positions scatter more than they
        should, their scatter counts. The displacement by then is uncertain too, alike for all frames.

        Args:
            displacement_sigma_px: ``(frames,)`` standard deviation of the displacement of every frame of the run.
        """
        known = np.isfinite(self.variance_px2) & (self.variance_px2 > 0)
        weight = np.zeros(len(known))
        weight[known] = 1 / self.variance_px2[known]
        if not known.any():
            weight[:] = 1.0
        weight /= weight.sum()
        mean = float(weight @ self.place_px)
        of_noise = float(weight[known] ** 2 @ self.variance_px2[known])
        of_scatter = float(weight**2 @ (self.place_px - mean) ** 2)
        of_path = displacement_sigma_px[self.frame] ** 2
        of_path = of_path[np.isfinite(of_path)]
        return mean, float(np.sqrt(max(of_noise, of_scatter) + (of_path.mean() if len(of_path) else 0.0)))


def start_by_ramps(
    measurement: Measurement, trajectory: Trajectory, ramps: Ramps, image: Floats | None, still: Floats | None
) -> tuple[SeenStart, SeenStart]:
    """Give the positions at frame 0 along x and y.

    Args:
        measurement: what was measured.
        trajectory: the object's displacement.
        ramps: what the first frames show.
        image: ``(m, m)`` image of the object at frame 0, which says by how much each dithered ramp is off; None for none.
        still: ``(m, m)`` image of what stands still, in units of the values, which is taken off; None for none.
    """
    total = _total_light(measurement, ramps)
    frames: Integers = np.flatnonzero((measurement.valid & (total > 0))[: ramps.frames])
    columns = [ramps.positive, ramps.negative]
    total, variance = total[frames], measurement.variance[frames][:, columns].sum(axis=1)
    first, second = measurement.values[frames][:, columns].T
    time_s = measurement.pattern_time_s[frames][:, columns]
    by_then_px = trajectory.at(time_s).mean(axis=1)
    shown = np.stack([_on_pixels(ramps, int(frame)) for frame in frames]) if len(frames) else np.zeros((0, 1, 1))
    if still is not None and len(frames):
        light, of_still = float(still.sum()), np.einsum("fyx,yx->f", shown, still)
        first, second, total = first - of_still, second - (light - of_still), total - light
    place_px = ramps.centroid_px(frames, first, second, total)
    if image is not None and image.sum() > 0:
        place_px = place_px - _dithering_px(ramps, frames, shown, by_then_px, image)
    noise_px2 = variance * (ramps.size / (2 * total)) ** 2
    axis = ramps.axis(frames)
    x, y = (
        SeenStart(frames[axis == k], (place_px - by_then_px[:, k])[axis == k], noise_px2[axis == k]) for k in range(2)
    )
    return x, y


def _total_light(measurement: Measurement, ramps: Ramps) -> Floats:
    """Total light of every frame, in the first ones as large in the mean as in as many frames after them.

    Edges of lit mirrors take more light from ramps than from the Hadamard patterns that come first, whether anybody knows of it
    or not.
    """
    total = measurement.steady_total
    lit = measurement.valid & (total > 0)
    first, after = (np.where(lit[part], total[part], 0.0) for part in _first_and_next(ramps.frames))
    if not (first.any() and after.any()):
        return total
    ratio = (after.sum() / np.count_nonzero(after)) / (first.sum() / np.count_nonzero(first))
    return np.asarray(total * np.where(np.arange(len(total)) < ramps.frames, ratio, 1.0), np.float64)


def _first_and_next(frames: int) -> tuple[slice, slice]:
    return slice(frames), slice(frames, 2 * frames)


def _on_pixels(ramps: Ramps, frame: int) -> Floats:
    """Give a frame's pattern in the place of H+ on the pixels of the field, ``(m, m)``."""
    finer = ramps.pattern(frame).reshape(ramps.size, ramps.upsampling, ramps.size, ramps.upsampling)
    return np.asarray(finer.mean(axis=(1, 3)), np.float64)


def _dithering_px(ramps: Ramps, frames: Integers, shown: Floats, by_then_px: Floats, image: Floats) -> Floats:
    """Give by how much each frame's centroid is off because its ramp is not grey, ``(n,)``.

    That is the centroid that its binary pattern gives of the image at its place, less the image's own.
    """
    light = float(image.sum())
    line = np.arange(ramps.size)
    off_px = np.empty(len(frames))
    for k, (frame, pattern) in enumerate(zip(frames.tolist(), shown, strict=True)):
        moved = shift(image, by_then_px[k, ::-1], order=1, mode="constant", prefilter=False)
        seen = float((pattern * moved).sum())
        (found,) = ramps.centroid_px(np.array([frame]), np.array([seen]), np.array([light - seen]), np.array([light]))
        off_px[k] = found - float(moved.sum(axis=frame % 2) @ line) / light
    return off_px
