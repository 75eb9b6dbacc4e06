"""Where the object's centroid is at frame 0, in px of the field: the absolute position, where the scheme measures one.

Moments measure it in every frame, ramps of the six-pattern scheme in the first ones. What a frame measures, less the
displacement by then, is the position at frame 0; the frames' mean is taken, weighted by their certainty.
"""

from dataclasses import replace
from typing import Final

import numpy as np

from instrument.measurement import Measurement
from instrument.schemes import Ramps, position_of
from instrument.tracking.ramp_start import SeenStart, start_by_ramps
from instrument.tracking.trajectory import Trajectory
from protocols import Floats

_MOST_LEAK: Final = 0.45


def with_start(
    measurement: Measurement, trajectory: Trajectory, *, image: Floats | None = None, still: Floats | None = None
) -> Trajectory:
    """Give a trajectory with the absolute position at frame 0, where the scheme measures one.

    Of the light model, leak, edge loss and ripples are out of the values already; what is not known of the leak is stated. A
    background that stands still pulls the centroid of all light towards its own, unless it is given.

    Args:
        measurement: what was measured.
        trajectory: the object's displacement.
        image: ``(m, m)`` image of the object at frame 0, on any scale: it says by how much the dithering of each ramp is off at
            the object's place. None where there is none.
        still: ``(m, m)`` image of what stands still, in units of the values; None where nothing is known of it. It is taken off
            ramps, but not off moments that are in every frame, whose displacement is that of all light too.

    Returns:
        The trajectory; as it is where the scheme measures displacement alone, or no frame that measures more is valid.
    """
    reading = position_of(measurement.scheme)
    if reading.ramps is not None:
        seen = start_by_ramps(measurement, trajectory, reading.ramps, image, still)
    elif reading.period_px is None:
        seen = _by_moments(measurement, trajectory)
    else:
        return trajectory
    if any(not len(axis.frame) for axis in seen):
        return trajectory
    found = [axis.mean(trajectory.sigma_px[:, k]) for k, axis in enumerate(seen)]
    start_px, sigma_px = np.array(found).T
    if reading.ramps is not None:
        sigma_px = np.hypot(sigma_px, _by_more_leak_px(measurement, trajectory, reading.ramps))
    return replace(trajectory, start_px=start_px, start_sigma_px=sigma_px)


def _by_more_leak_px(measurement: Measurement, trajectory: Trajectory, ramps: Ramps) -> Floats:
    """``(2,)``: by how much the position moves if the leak is larger by its standard deviation."""
    leak = measurement.light.leak
    if not leak.sigma:
        return np.zeros(2)
    more = leak.model_copy(update={"value": min(leak.value + leak.sigma, _MOST_LEAK)})
    changed = measurement.lit_by(measurement.light.model_copy(update={"leak": more}))
    starts = [start_by_ramps(light, trajectory, ramps, None, None) for light in (measurement, changed)]
    return np.array([float((after.place_px - before.place_px).mean()) for before, after in zip(*starts, strict=True)])


def _by_moments(measurement: Measurement, trajectory: Trajectory) -> tuple[SeenStart, SeenStart]:
    found = measurement.observe(steady=True)
    frames = np.flatnonzero(found.valid)
    place_px = found.signal.real - found.expected_direction(trajectory.displacement_px).real
    variance = found.variance_px2(found.signal.real)
    x, y = (SeenStart(frames, place_px[frames, axis], variance[frames, axis]) for axis in range(2))
    return x, y
