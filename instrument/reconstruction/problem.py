"""The problem that a solver is given: values, displacement of the object during each, and unknown pixels."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from instrument.measurement import ImageValues, Measurement, fixed_columns
from instrument.numerics import Stacked, Weighted
from instrument.reconstruction.correlation import FixedPatterns
from instrument.reconstruction.fourier_rows import FourierRows
from instrument.reconstruction.region import Region
from instrument.reconstruction.shifted_hadamard import ShiftedHadamard
from instrument.schemes import Scheme, image_rows_of, position_of
from instrument.tracking import Trajectory
from protocols import Floats, InputError, Singles


@dataclass(frozen=True, eq=False)
class Places:
    """Displacement of the object, x and y in px, during the patterns of each valid frame."""

    positive: Floats
    """``(rows, 2)``: displacement during H+."""

    negative: Floats
    """``(rows, 2)``: displacement during H-."""

    fixed: Floats
    """``(rows, k, 2)``: during each pattern that measures position."""

    @classmethod
    def along(cls, trajectory: Trajectory, values: ImageValues) -> Self:
        """Read a trajectory at the times of the patterns."""
        place_px = trajectory.at(values.time_s)
        return cls(place_px[:, 0], place_px[:, 1], place_px[:, 2:])

    @property
    def every_px(self) -> Floats:
        """``(n, 2)``: all displacements."""
        return np.concatenate([self.positive, self.negative, self.fixed.reshape(-1, 2)])


@dataclass(frozen=True, eq=False)
class Problem:
    """The problem of finding one image."""

    scheme: Scheme
    """Scheme of the patterns shown."""

    values: ImageValues
    """Values measured."""

    places: Places
    """Displacement of the object."""

    region: Region
    """Unknown pixels; the image is 0 elsewhere."""

    @classmethod
    def of(cls, measurement: Measurement, values: ImageValues, trajectory: Trajectory, *, inside: bool) -> Self:
        """State the problem of a run.

        Args:
            measurement: measurement of the run.
            values: image values of the run.
            trajectory: displacement of the object.
            inside: whether the object stays inside the field in every frame, so that only pixels which it can occupy are
                unknown.

        Raises:
            InputError: the displacements leave no room for an object in the field.
        """
        places = Places.along(trajectory, values)
        region = Region.inside(places.every_px, values.size) if inside else Region.whole(values.size)
        return cls(measurement.scheme, values, places, region)

    def moved(self, trajectory: Trajectory) -> "Problem":
        """State the same problem for another trajectory."""
        return Problem(self.scheme, self.values, Places.along(trajectory, self.values), self.region)

    def hadamard(self) -> tuple[Weighted, Singles]:
        """Give whitened rows of the differences I_H+ - I_H-, and the whitened differences, ``(rows,)``."""
        values, places = self.values, self.places
        operator = ShiftedHadamard.differential(
            values.pairs, places.positive, places.negative, values.size, self.region
        )
        sigma = values.difference_sigma
        return Weighted(operator, (1 / sigma).astype(np.float32)), (values.difference / sigma).astype(np.float32)

    def with_fourier(self) -> tuple[Stacked, Singles]:
        """Give whitened rows of the differences and of the Fourier values' dithering, and their whitened values.

        Raises:
            InputError: the scheme has no Fourier patterns.
        """
        if not any(column.role == "fourier" for column in self.scheme.columns):
            raise InputError(
                saw=f"the method tv-fourier for the scheme {self.scheme.name}",
                expected="a scheme with Fourier patterns",
                remedy='take the method "tv"',
            )
        rows, differences = self.hadamard()
        values, places_px = self.values, self.places.fixed
        sigma = np.sqrt(values.fixed_variance)
        fixed = self.fixed_patterns(places_px)
        along = [0 if self.scheme.columns[int(k)].axis == "x" else 1 for k in fixed_columns(self.scheme)]
        period_px = position_of(self.scheme).period_px or np.inf
        fourier = FourierRows.of(fixed, places_px, sigma, 1 / period_px, along)
        whitened = (values.fixed / sigma).astype(np.float32).ravel()
        return Stacked(rows, fourier), np.concatenate([differences, fourier.dithering(whitened)])

    def fixed_patterns(self, places_px: Floats | None = None) -> FixedPatterns:
        """Give the patterns that measure position, as ``FixedPatterns.of`` prepares them.

        A scheme may show others in every frame too, such as an all-on pattern for the total light: they are left out.
        """
        rows = image_rows_of(self.scheme)
        in_every_frame = [k for k in range(len(self.scheme.columns)) if k not in {rows.positive, rows.negative}]
        own = np.searchsorted(in_every_frame, fixed_columns(self.scheme))
        return FixedPatterns.of(self.scheme.fixed_patterns[own], self.values.size, self.region, places_px)
