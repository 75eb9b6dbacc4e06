"""Reconstruction of the sharp image from a recording and the object's motion."""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import DTypeLike, NDArray

from instrument.choices import Extent, Method
from instrument.measurement import Measurement, first_light
from instrument.numerics import one_blas_thread
from instrument.reconstruction.methods import Solution, method_of
from instrument.reconstruction.problem import Problem
from instrument.reconstruction.region import Region
from instrument.recording import Recording
from instrument.shown import card, grey, line
from instrument.tables import data_set
from instrument.tracking import Trajectory, as_trajectory
from protocols import Floats, InputError
from protocols.field_docs import with_fields


@with_fields
@dataclass(frozen=True, eq=False)
class Reconstruction:
    """The image of the object at its position in the reference frame of its path. ``numpy.asarray`` gives ``image``."""

    image: Floats
    """``(grid image_size, grid image_size)``, row = y (down), column = x; ``(grid rows, grid columns)`` where ``region`` reaches
    outside the field: then ``field`` says where in it the field is. Transmission 0 to 1 where values count lit pixels. Photon
    counts have no absolute scale: there the brightest pixel is 1."""

    method: str
    """Name of the method that made it."""

    gain: float
    """Value units (photons) for one pixel of ``image`` = 1 and one pattern; 1 where the image is on the values' own scale."""

    noise: float
    """Standard deviation of a single value, rms over frames, in its own units."""

    misfit: float
    """Root mean square of what the image leaves unexplained, over the noise: about 1 where motion and image are right. Where
    ``unknowns`` is known, it is that of each value which is left over beside them; else less than 1, where values are few."""

    iterations: int
    """Number of iterations of the solver; 0 where it has none."""

    region: Region
    """Pixels where the image may differ from 0, in px of the field."""

    field: Region
    """Where the field is in the image, in px of the patterns: its pixel (0, 0) is at row ``top`` and column ``left``, which are 0
    unless the region reaches outside."""

    still: Floats | None = None
    """``(size, size)``: image of what stands still, on the patterns' grid and the same scale; None where it was not asked for."""

    grid: int = 1
    """Pixels of ``image`` that a pattern pixel has along each axis."""

    unknowns: float | None = None
    """Effective number of unknowns that the image took from the values; None where nobody asked for it."""

    @property
    def at_patterns(self) -> Floats:
        """``(image_size, image_size)``, or ``(rows, columns)`` of a wide one: the image at the patterns' resolution."""
        return binned(self.image, self.grid)

    @property
    def in_field(self) -> Floats:
        """``(image_size, image_size)``: what of it is inside the field in that frame, at the patterns' resolution."""
        field = self.field
        return self.at_patterns[field.top : field.top + field.height, field.left : field.left + field.width]

    @property
    def wide(self) -> bool:
        """Whether the image reaches outside the field."""
        return self.at_patterns.shape != self.field.shape

    @property
    def edges_px(self) -> tuple[float, float, float, float] | None:
        """Edges of a wide image, left, right, lower and upper, in px of the field; None of one that is the field's."""
        if not self.wide:
            return None
        left, top = -self.field.left - 0.5, -self.field.top - 0.5
        rows, columns = self.at_patterns.shape
        return left, left + columns, top + rows, top

    def __repr__(self) -> str:
        """Say in one line what it is."""
        return line("Reconstruction", *self._facts().values())

    def _repr_html_(self) -> str:
        """Show the image in a notebook."""
        return card("Reconstruction", self._facts(), grey(self.image, "the reconstructed image"))

    def _facts(self) -> dict[str, str]:
        rows, columns = self.image.shape
        return {
            "pixels": f"{columns} x {rows} px" + (f", {self.grid} x {self.grid} to a pattern pixel" * (self.grid > 1)),
            "method": self.method,
            "misfit": f"misfit {self.misfit:.3f} (1 is the noise alone)",
        }

    def to_xarray(self) -> Any:
        """Give the image, and what stands still, as an ``xarray.Dataset`` with places in px of the patterns.

        Raises:
            InputError: xarray is not installed.
        """
        images = {"image": (("y_px", "x_px"), self.image)}
        middles = (np.arange(len(self.image)) + 0.5) / self.grid - 0.5
        coordinates = {name: ((name,), middles) for name in ("y_px", "x_px")}
        if self.still is not None:
            images["still"] = (("y_pattern_px", "x_pattern_px"), self.still)
            whole = np.arange(len(self.still), dtype=np.float64)
            coordinates |= {name: ((name,), whole) for name in ("y_pattern_px", "x_pattern_px")}
        attributes: dict[str, str | float] = {"method": self.method, "misfit": self.misfit, "gain": self.gain}
        return data_set(images, coordinates, attributes, dict.fromkeys(coordinates, "px"))

    def __array__(self, dtype: DTypeLike | None = None, copy: bool | None = None) -> NDArray[Any]:  # noqa: FBT001  (numpy's own signature)
        """Give ``image`` to numpy."""
        return np.array(self.image, dtype=dtype, copy=copy)

    @classmethod
    def of(cls, problem: Problem, solution: Solution, method: str) -> "Reconstruction":
        """Place the solution in the whole field, and scale it."""
        values = problem.values
        image = solution.region.paste(solution.image.astype(np.float64), values.size)
        gain = float(image.max()) if values.photon_counts and image.max() > 0 else 1.0
        still = None if solution.still is None else solution.still.astype(np.float64) / gain
        return cls(
            image / gain,
            method,
            gain,
            values.noise,
            solution.misfit,
            solution.iterations,
            solution.region,
            field_in(solution.region, values.size),
            still,
            problem.field.grid,
        )


def light_for(recording: Recording | Measurement, region: Extent | Region) -> Measurement:
    """Correct a recording by what it shows of the bench's light, as far as that can be told for such a region.

    Where what is in the field changes, the signals of position patterns lie on no circle whose centre were their offset: there
    nothing is taken from the run before its image is known.
    """
    measurement = Measurement.of(recording)
    size = measurement.plan.image_size
    passes = region == "wide" if isinstance(region, str) else region.with_field(size) != Region.whole(size)
    if passes and not measurement.light_found:
        return replace(measurement, light_found=True)
    return first_light(measurement)


def field_in(region: Region, size: int) -> Region:
    """Give where a field of ``size`` pixels a side is in the image of a region, as ``Region.paste`` makes it."""
    whole = region.with_field(size)
    return Region(-whole.top, -whole.left, size, size)


def binned(image: Floats, grid: int) -> Floats:
    """Give the means over squares of ``grid`` x ``grid`` pixels."""
    height, width = image.shape[0] // grid, image.shape[1] // grid
    return np.asarray(image.reshape(height, grid, width, grid).mean(axis=(1, 3)), np.float64)


@one_blas_thread()
def reconstruct(
    recording: Recording | Measurement,
    motion: Trajectory | Floats | None,
    method: Method = "tv",
    *,
    region: Extent | Region = "inside",
    grid: int = 1,
    still: bool = False,
    strength: float | None = None,
) -> Reconstruction:
    """Reconstruct the image at frame 0.

    Args:
        recording: recording of a scheme with an image. Frames that are not valid are left out.
        motion: what ``track`` gave, or ``(frames, 2)`` displacements (x, y) in px in the middle of each frame, or None for an
            object at rest.
        method: ``tv`` is least total variation with the edges found reweighted. ``tv-fourier`` uses the Fourier values too, whose
            dithering depends on the object's shape: it helps where the noise is weak, and takes three times as long.
            ``tv-bregman`` takes a Bregman step instead of reweighting. ``tv-al`` is TVAL3's model with its default weights, for
            comparison. ``pseudo-inverse`` is least squares without any smoothing. ``dgi`` is differential ghost imaging.
            ``conventional`` is the inverse Hadamard transform, which ignores the motion.
            ``docs/decisions/0008-edge-reweighted-tv.md`` compares them.
        region: which pixels are solved for. ``inside``: those that the object can occupy while it stays inside the field in every
            frame; values are divided by the smoothed total light. ``field``: all that are inside at frame 0. ``wide``: all that
            the field sees in one frame or more, so that of an object that passes by the image is larger than the field, and of
            one that is itself larger too. Or a ``Region`` of one's own, in px of the field, which may reach outside. But for
            ``inside`` the light is taken as steady.
        grid: image pixels that a pattern pixel has along each axis. More than 1 shows what the object's motion by fractions of a
            pixel shows, and takes the longer.
        still: whether an image of what stands still is found beside that of the object, for a background that nobody measured.
        strength: strength of the smoothing in units of the noise; None takes the method's usual one.

    Raises:
        InputError: there is no valid frame, the displacements have another shape or leave no room for an object in the field,
            method or region are unknown, or the method has no strength or no finer grid and one is given.
    """
    chosen = method_of(method)
    if strength is not None and chosen.strength is None:
        raise InputError(
            saw=f"a strength of {strength:g} for the method {method}",
            expected="no strength: this method has none",
            remedy="leave it out, or take another method",
        )
    if grid > 1 and not chosen.finer:
        raise InputError(
            saw=f"grid = {grid} for the method {method}",
            expected="a method that finds an image between the pixels of the patterns",
            remedy='leave grid out, or take the method "tv"',
        )
    measurement = light_for(recording, region)
    values = measurement.image_values(steady_object=region == "inside")
    trajectory = as_trajectory(motion, len(measurement), measurement.frame_time_s)
    problem = Problem.of(measurement, values, trajectory, region=region, grid=grid, still=still)
    wanted = strength if strength is not None else chosen.strength or 0.0
    if problem.profile is not None:  # its image says how much light the object lets through where it is
        first = chosen.solve(problem, wanted)
        problem = problem.seen_as(first.image, first.still)
    return Reconstruction.of(problem, chosen.solve(problem, wanted), method)
