"""What a recording and a trajectory say about the image: whitened Hadamard rows."""

from dataclasses import dataclass

import numpy as np

from instrument.light import corrected_values
from instrument.reconstruction.correlation import FixedPatterns
from instrument.reconstruction.fourier_rows import FourierRows
from instrument.reconstruction.operator import ShiftedHadamard, Stacked, Weighted
from instrument.reconstruction.region import Region
from instrument.recording import Recording
from instrument.schemes import FourierHadamard, scheme_of
from instrument.tracking import Trajectory
from instrument.tracking.smoothing import smooth
from protocols import Floats, InputError, Integers, Mask, Singles

POSITIVE, NEGATIVE = 4, 5
"""Columns of I_H+ and I_H-."""

_FEWEST = 8  # frames from which a drift of the light can be told
_LEAST_NOISE = 5e-4  # of the rms of the values: a run without noise is solved to this


@dataclass(frozen=True, eq=False)
class Measurement:
    """The values of the valid frames, ready for any trajectory: what does not change when the motion is refined."""

    frame: Integers
    """``(rows,)``: index of each valid frame."""

    pairs: Integers
    """``(rows, 2)``: Walsh rows of its Hadamard pattern."""

    values: Floats
    """``(rows, 6)``: corrected for dead time and dark counts, divided by ``light``."""

    variance: Floats
    """``(rows, 6)``: of ``values``. Of photons, I_H+ and I_H- have that of their sum, smoothed over frames, by halves: each
    count as its own variance would make low counts weigh more."""

    light: Floats
    """``(rows,)``: smoothed total light over its mean; 1 where the total light may change by itself."""

    size: int
    """Pixels a side of the field."""

    photon_counts: bool
    """Whether values are photons."""

    @classmethod
    def of(cls, recording: Recording, *, steady_object: bool) -> "Measurement":
        """Take the valid frames of a recording.

        Args:
            recording: of the six-pattern scheme.
            steady_object: whether the object stays inside the field, so that a change of the total light is one of the lamp
                and is divided out (smoothed over frames).

        Raises:
            InputError: no valid frame.
        """
        values, variance = corrected_values(recording)
        valid: Mask = recording.frame_valid & np.isfinite(values).all(axis=1)
        if not valid.any():
            raise InputError(
                saw=f"no valid frame in a recording of {len(recording)}",
                expected="at least one",
                remedy="look at the recording's timing report",
            )
        values, variance = values[valid], variance[valid]
        total: Floats = values[:, POSITIVE] + values[:, NEGATIVE]
        light = np.ones(len(total))
        if steady_object and len(total) >= _FEWEST and (total > 0).any():
            light = smooth(total, np.ones(len(total)), orders=(1,)).values
            light = np.maximum(light / light.mean(), 1e-3)
        if recording.photon_counts and len(total) >= _FEWEST:
            both = variance[:, POSITIVE] + variance[:, NEGATIVE]
            variance[:, POSITIVE:] = smooth(both, np.ones(len(both)), orders=(1,)).values[:, None] / 2
        floor = (_LEAST_NOISE * float(np.sqrt(np.mean(np.square(values))))) ** 2 + 1e-30
        variance = np.where(np.isfinite(variance), np.maximum(variance, floor), floor)
        scheme = scheme_of(recording.plan)
        frame = np.flatnonzero(valid)
        return cls(
            frame=frame,
            pairs=scheme.order[frame % len(scheme.order)],
            values=values / light[:, None],
            variance=variance / light[:, None] ** 2,
            light=light,
            size=recording.plan.image_size,
            photon_counts=recording.photon_counts,
        )

    @property
    def difference(self) -> Floats:
        """``(rows,)``: I_H = I_H+ - I_H-."""
        return self.values[:, POSITIVE] - self.values[:, NEGATIVE]

    @property
    def difference_sigma(self) -> Floats:
        """``(rows,)``: standard deviation of that."""
        return np.sqrt(self.variance[:, POSITIVE] + self.variance[:, NEGATIVE])

    def hadamard(self, places_px: Floats, region: Region) -> tuple[Weighted, Singles]:
        """Whitened rows of the differences, and the whitened differences.

        Args:
            places_px: ``(rows, 6, 2)``: displacement during each pattern.
            region: pixels of the image that are unknown.
        """
        operator = ShiftedHadamard.differential(
            self.pairs, places_px[:, POSITIVE], places_px[:, NEGATIVE], self.size, region
        )
        weight = (1 / self.difference_sigma).astype(np.float32)
        return Weighted(operator, weight), (self.difference / self.difference_sigma).astype(np.float32)

    def with_fourier(self, scheme: FourierHadamard, places_px: Floats, region: Region) -> tuple[Stacked, Singles]:
        """Whitened rows of the differences and of the Fourier values' dithering, and their whitened values.

        Args:
            scheme: whose Fourier patterns.
            places_px: as in ``hadamard``.
            region: as in ``hadamard``.
        """
        hadamard, differences = self.hadamard(places_px, region)
        places_px = places_px[:, :POSITIVE]
        sigma = np.sqrt(self.variance[:, :POSITIVE])
        fixed = FixedPatterns.of(scheme, region, places_px)
        fourier = FourierRows.of(fixed, places_px, sigma, scheme.plan.frequency_per_px)
        whitened = (self.values[:, :POSITIVE] / sigma).astype(np.float32).ravel()
        return Stacked(hadamard, fourier), np.concatenate([differences, fourier.dithering(whitened)])


def as_trajectory(motion: Trajectory | Floats, recording: Recording) -> Trajectory:
    """Take displacements as they come: a trajectory, or ``(frames, 2)`` px in the middle of each frame.

    Raises:
        InputError: not one finite displacement for each frame.
    """
    if isinstance(motion, Trajectory):
        trajectory = motion
    else:
        places = np.asarray(motion, np.float64)
        trajectory = Trajectory(
            displacement_px=places,
            sigma_px=np.zeros_like(places),
            frame_time_s=recording.frame_time_s,
            method="given",
            valid=np.ones(len(places), np.bool_),
        )
    shape = trajectory.displacement_px.shape
    if shape != (len(recording), 2) or not np.isfinite(trajectory.displacement_px).all():
        raise InputError(
            saw=f"displacements of shape {shape}, {np.count_nonzero(~np.isfinite(trajectory.displacement_px))} not finite",
            expected=f"finite displacements of shape ({len(recording)}, 2): x, y of each recorded frame",
            remedy="pass the trajectory that track() gives for this recording",
        )
    return trajectory


def places_px(trajectory: Trajectory, recording: Recording, measurement: Measurement) -> Floats:
    """``(rows, 6, 2)``: displacement of the object while each pattern of each valid frame was shown."""
    return trajectory.at(recording.pattern_time_s[measurement.frame])
