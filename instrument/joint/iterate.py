"""A path and a light model, as far as they are known, and the image problem that they state."""

from dataclasses import dataclass, replace

from instrument.measurement import LightModel, Measurement
from instrument.reconstruction import Problem, Region
from instrument.tracking import Trajectory
from protocols import Floats, Singles


@dataclass(frozen=True, eq=False)
class Iterate:
    """A path and a light model, and the image problem that they state."""

    measurement: Measurement
    """What was measured, corrected by the light model."""

    problem: Problem
    """Image values, and the displacement during each pattern."""

    trajectory: Trajectory
    """The path."""

    refinements: int = 0
    """Number of refinements that led to it."""

    def lit_by(self, light: LightModel) -> "Iterate":
        """Correct the values by another light model."""
        if light == self.measurement.light:
            return self
        measurement = self.measurement.lit_by(light)
        return replace(self, measurement=measurement, problem=self.problem.remeasured(measurement))

    def on_grid(self, grid: int) -> "Iterate":
        """Take another number of image pixels a pattern pixel."""
        return replace(self, problem=self.problem.on_grid(grid))

    def seen_as(self, image: Singles, still: Singles | None) -> "Iterate":
        """Give the values the changes of light that stem from the object's place; see ``Problem.seen_as``."""
        return replace(self, problem=self.problem.seen_as(image, still))

    def about(self, pivot_px: Floats) -> "Iterate":
        """Let the object turn and grow about a point from here on, ``(2,)`` x and y where it is not displaced."""
        trajectory = replace(self.trajectory, pivot_px=pivot_px)
        return replace(self, problem=self.problem.moved(trajectory), trajectory=trajectory)

    def within(self, region: Region) -> "Iterate":
        """Take an image that is 0 outside another region."""
        return replace(self, problem=self.problem.within(region))

    def along(self, trajectory: Trajectory) -> "Iterate":
        """Take another path."""
        return replace(
            self, problem=self.problem.moved(trajectory), trajectory=trajectory, refinements=self.refinements + 1
        )
