"""The problem that a solver is given: values, displacement of the object during each, and unknown pixels."""

from dataclasses import dataclass, replace
from typing import Final, Self, get_args

import numpy as np

from instrument.choices import Extent
from instrument.measurement import ImageValues, Measurement, Profile, fixed_columns
from instrument.numerics import InTime, Layered, Operator, Stacked, Unseen, Weighted
from instrument.reconstruction.correlation import FixedPatterns
from instrument.reconstruction.field import Field
from instrument.reconstruction.fourier_rows import FourierRows
from instrument.reconstruction.lit_rows import Brightness, Lit
from instrument.reconstruction.object_shape import ObjectShape
from instrument.reconstruction.region import Region
from instrument.reconstruction.shifted_hadamard import ShiftedHadamard
from instrument.reconstruction.still_hadamard import StillHadamard
from instrument.reconstruction.turned_hadamard import DenseRows, TurnedRows
from instrument.reconstruction.window_rows import WindowRows
from instrument.schemes import Scheme, image_rows_of, position_of
from instrument.tracking import Trajectory
from protocols import Bytes, Floats, InputError, Singles

_OF_WINDOW: Final = 0.35
"""Length of a row of what is in the field, over that of a Hadamard difference, at most: at 0.5 the solver takes twice as long."""


@dataclass(frozen=True, eq=False)
class Places:
    """Displacement of the object, x and y in px, during the patterns of each valid frame."""

    positive: Floats
    """``(rows, 2)``: displacement during H+."""

    negative: Floats
    """``(rows, 2)``: displacement during H-."""

    fixed: Floats
    """``(rows, k, 2)``: during each pattern that measures position."""

    shape: ObjectShape | None = None
    """How the object is turned, and how large it is; None where its shape stays."""

    @classmethod
    def along(cls, trajectory: Trajectory, values: ImageValues) -> Self:
        """Read a trajectory at the times of the patterns."""
        place_px = trajectory.at(values.time_s)
        return cls(place_px[:, 0], place_px[:, 1], place_px[:, 2:], ObjectShape.along(trajectory, values.time_s))

    @property
    def pair_px(self) -> Floats:
        """``(rows, 2)``: displacement in the middle between H+ and H-."""
        return (self.positive + self.negative) / 2

    @property
    def every_px(self) -> Floats:
        """``(n, 2)``: all displacements."""
        return np.concatenate([self.positive, self.negative, self.fixed.reshape(-1, 2)])

    @property
    def middle_px(self) -> Floats:
        """``(rows, 2)``: displacement in the middle of the patterns that measure position; where there are none, of H+ and H-."""
        return self.fixed.mean(axis=1) if self.fixed.shape[1] else (self.positive + self.negative) / 2


def _region_of(extent: Extent, places_px: Floats, size: int) -> Region:
    """Give the region that a word names, for all displacements, ``(n, 2)``.

    Raises:
        InputError: the displacements leave no room for an object in the field, or there is no such word.
    """
    if extent == "inside":
        return Region.inside(places_px, size)
    if extent == "field":
        return Region.whole(size)
    if extent == "wide":
        return Region.seen(places_px, size)
    raise InputError(
        saw=f"the region {extent!r}",
        expected=f"one of {', '.join(get_args(Extent))}, or a Region",
        remedy="correct the name",
    )


@dataclass(frozen=True, eq=False)
class Problem:
    """The problem of finding the image of the object, and that of what stands still behind it."""

    scheme: Scheme
    """Scheme of the patterns shown."""

    values: ImageValues
    """Values measured."""

    places: Places
    """Displacement of the object."""

    region: Region
    """Unknown pixels of the object; the image is 0 elsewhere."""

    field: Field
    """Field of the patterns, and the grid of the object's image."""

    steady: bool
    """Whether values were divided by the total light, as its changes stem from the lamp: the object stays inside the field."""

    still: bool = False
    """Whether light of something that stands still is unknown too: a second image, of the whole field, on the patterns' grid."""

    profile: Profile | None = None
    """How bright the field is lit; None for evenly."""

    seen: Floats | None = None
    """``(rows,)``: total light that the object lets through where it is, over its mean, by which ``values`` were multiplied; None
    for 1. They were divided by the total light, as if all its changes stemmed from the lamp."""

    @classmethod
    def of(
        cls,
        measurement: Measurement,
        values: ImageValues,
        trajectory: Trajectory,
        *,
        region: Extent | Region,
        grid: int = 1,
        still: bool = False,
    ) -> Self:
        """State the problem of a run.

        Args:
            measurement: measurement of the run.
            values: image values of the run.
            trajectory: displacement of the object.
            region: unknown pixels: by a word as in ``reconstruct``, or themselves.
            grid: image pixels that a pattern pixel has along each axis.
            still: whether there is a still background that nobody measured.

        Raises:
            InputError: the displacements leave no room for an object in the field.
        """
        places = Places.along(trajectory, values)
        unknown = region if isinstance(region, Region) else _region_of(region, places.every_px, values.size)
        field = Field(values.size, grid, measurement.edge_loss_a_side)
        steady = region == "inside" and measurement.normalise != "off"
        return cls(measurement.scheme, values, places, unknown, field, steady, still, measurement.light.profile)

    def moved(self, trajectory: Trajectory) -> "Problem":
        """State the same problem for another trajectory."""
        return replace(self, places=Places.along(trajectory, self.values))

    def remeasured(self, measurement: Measurement) -> "Problem":
        """State the same problem for the same run, corrected by another light model."""
        values = measurement.image_values(steady_object=self.steady)
        if self.seen is not None:
            values = values.times(self.seen)
        return replace(self, values=values, field=replace(self.field, edge_loss=measurement.edge_loss_a_side))

    def seen_as(self, image: Floats | Singles, still: Floats | Singles | None) -> "Problem":
        """Give the values their changes of light that stem from the object.

        Those are from its place in a field that is not evenly lit, and from its size.

        Args:
            image: image of the object, of the problem's region and on any grid.
            still: ``(size, size)`` image of what stands still; None for nothing.
        """
        if (self.profile is None and self.places.shape is None) or not self.steady:
            return self
        own = self.on_grid(image.shape[0] // self.region.height).all_light()
        light, _ = self.total_light(own, np.asarray(image, np.float32))
        light = light + (0.0 if still is None else float(still.sum(dtype=np.float64)))
        if not (light > 0).all():
            return self
        seen = light / light.mean()
        return replace(self, values=self.values.times(seen if self.seen is None else seen / self.seen), seen=seen)

    def fixed_values(self, patterns: FixedPatterns, image: Singles) -> tuple[Floats, Floats]:
        """Give the values of an image that patterns measure during those that measure position, and their derivatives.

        Args:
            patterns: as many as those that measure position, on the problem's grid.
            image: image pixels of the region.

        Returns:
            ``(rows, k)``, and ``(rows, k, 2)`` by x and y, per px.
        """
        places, shape = self.places, self.places.shape
        if shape is None:
            return patterns.values(patterns.maps(image), places.fixed)
        return shape.values(patterns, image, places.fixed, shape.fixed)

    def total_light(self, all_light: FixedPatterns, image: Singles) -> tuple[Floats, Floats]:
        """``(rows,)``: light of an image through a pattern that lets all through, ``all_light``; its slopes, ``(rows, 2)``."""
        places, shape = self.places, self.places.shape
        middle_px = places.middle_px[:, None]
        if shape is None:
            light, slopes = all_light.values(all_light.maps(image), middle_px)
        else:
            light, slopes = shape.values(all_light, image, middle_px, shape.fixed.mean(axis=1, keepdims=True))
        return light[:, 0], slopes[:, 0]

    def within(self, region: Region) -> "Problem":
        """State the same problem for an image that is 0 outside another region."""
        return replace(self, region=region)

    def turned_rows(self) -> TurnedRows:
        """Give the Hadamard patterns as an object sees them whose shape changes, both of a pair at their common middle.

        Raises:
            ValueError: the shape stays.
        """
        shape = self.places.shape
        if shape is None:
            raise ValueError("rows of an object that turns, for one that does not")
        pose = np.hstack([self.places.pair_px, shape.pair])
        return TurnedRows(self.field, self.values.pairs, pose, shape.pivot_px, self.region)

    def with_still(self) -> "Problem":
        """State the problem with an image of what stands still too."""
        return replace(self, still=True)

    def on_grid(self, grid: int) -> "Problem":
        """State the same problem with another number of image pixels a pattern pixel."""
        return replace(self, field=replace(self.field, grid=grid))

    def hadamard(self) -> tuple[Weighted, Singles]:
        """Give whitened rows of the differences I_H+ - I_H-, and the whitened differences, ``(rows,)``."""
        values, places = self.values, self.places
        operator: Operator
        if places.shape is None:
            operator = ShiftedHadamard.differential(
                values.pairs, places.positive, places.negative, self.field, self.region
            )
        else:
            rows = self.turned_rows()
            operator = DenseRows(rows.matrix(), rows.image_shape)
        brightness = self.brightness()
        if brightness is not None:
            operator = Lit(operator, brightness)
        if self.still:
            operator = Layered((operator, StillHadamard.of(values.pairs, self.field)))
        sigma = values.difference_sigma
        return Weighted(operator, (1 / sigma).astype(np.float32)), (values.difference / sigma).astype(np.float32)

    @property
    def passes(self) -> bool:
        """Whether the unknown pixels reach outside the field, so that what is in it changes from frame to frame."""
        return self.region.with_field(self.values.size) != Region.whole(self.values.size)

    def rows(self) -> tuple[Operator, Singles]:
        """Give whitened rows and values of all that is to be solved for together, by total variation.

        Those are the differences, as ``hadamard`` gives them, and of an object that passes by what every frame measures of what
        is in the field. Of the latter no row is longer than a share of a difference's: more would not be known better, but
        slow down the solver. Where a background is unknown too, what is steady is left out.
        """
        rows, differences = self.hadamard()
        if not self.passes or self.places.shape is not None:
            return rows, differences
        values = self.values
        patterns = np.concatenate([self.all_light().patterns, self.fixed_patterns().patterns])
        places_px = np.concatenate([self.places.pair_px[:, None], self.places.fixed], axis=1)
        total: Floats = (values.positive + values.negative)[:, None]
        of_fixed = np.sqrt(values.fixed_variance + values.difference_variance[:, None] / 4)
        sigma = np.hstack([values.difference_sigma[:, None], of_fixed])
        window = WindowRows.of(patterns, places_px, sigma, self.field, self.region)
        longest = _OF_WINDOW * values.size / self.field.grid / float(np.median(values.difference_sigma))
        in_time = InTime.of(window, window.columns, longest, steady=not self.still)
        seen = np.hstack([total, values.fixed - total / 2]) / sigma
        also: Operator = in_time
        if self.still:
            also = Layered((in_time, Unseen(in_time.shape[0], rows.image_shapes[1:])))
        return Stacked(rows, also), np.concatenate([differences, in_time.terms(seen.astype(np.float32).ravel())])

    @property
    def finer(self) -> tuple[int, ...]:
        """For each unknown image, how many times smaller than the patterns' its pixels are."""
        return (self.field.grid, 1) if self.still else (self.field.grid,)

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
        seen: Operator = fourier
        if self.still:  # light that stands still adds a constant, which is projected off
            seen = Layered((fourier, Unseen(fourier.shape[0], rows.image_shapes[1:])))
        return Stacked(rows, seen), np.concatenate([differences, fourier.dithering(whitened)])

    def fixed_patterns(self, places_px: Floats | None = None) -> FixedPatterns:
        """Give the patterns that measure position as they act, as ``FixedPatterns.of`` prepares them."""
        return FixedPatterns.of(self._lit(self.field.acting(self._shown)), self.field, self.region, places_px)

    def fixed_borders(self) -> FixedPatterns:
        """Give what these patterns lose of each pixel's light for an edge loss of 1, prepared likewise."""
        return FixedPatterns.of(self._lit(self.field.bordering(self._shown)), self.field, self.region)

    def all_light(self) -> FixedPatterns:
        """Give the pattern that lets all light through, prepared likewise."""
        all_on = np.full((1, self.field.pixels, self.field.pixels), 1 / self.field.grid**2, np.float32)
        return FixedPatterns.of(self._lit(all_on), self.field, self.region)

    def brightness(self) -> Brightness | None:
        """Give the brightness through which the object is seen in each row; None where the field is lit evenly."""
        if self.profile is None:
            return None
        return Brightness.of(self.profile.over(self.field.size), self.places.pair_px, self.field, self.region)

    def _lit(self, patterns: Singles) -> Singles:
        """Give patterns, ``(n, pixels, pixels)``, in the light that falls on them."""
        if self.profile is None:
            return patterns
        return np.asarray(
            patterns * self.profile.over(self.field.size).repeat(self.field.grid, 0).repeat(self.field.grid, 1),
            np.float32,
        )

    def of_still(self, still: Floats | Singles) -> Floats:
        """``(k,)``: values that these patterns give of an image at rest, ``(size, size)`` on the patterns' grid."""
        acting = replace(self.field, grid=1).acting(self._shown)
        return np.asarray(np.einsum("kyx,yx->k", acting, still, dtype=np.float64), np.float64)

    @property
    def _shown(self) -> Bytes:
        """``(k, samples, samples)``: the patterns that measure position, as they are shown.

        A scheme may show others in every frame too, such as an all-on pattern for the total light: they are left out.
        """
        rows = image_rows_of(self.scheme)
        in_every_frame = [k for k in range(len(self.scheme.columns)) if k not in {rows.positive, rows.negative}]
        return self.scheme.fixed_patterns[np.searchsorted(in_every_frame, fixed_columns(self.scheme))]
