"""What stands in front of a simulated bench, as far as the framework may know it: its clock and its truth."""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

from protocols.clock import Clock
from protocols.modulator import PixelGrid
from protocols.values import Floats


@dataclass(frozen=True, eq=False)
class Truth:
    """Truth of a simulated run: what it really showed."""

    displacement_px: Floats
    """``(frames, 2)`` displacement along x and y at each asked time, in image pixels, relative to the first."""

    image: Floats
    """``(image_size, image_size)`` transmission of the object at the first asked time, row = y (down), column = x. A blur of the
    optics is in it, uneven light is not."""

    background: Floats | None = None
    """``(image_size, image_size)`` transmission of what stands still beside the object; None where there is nothing."""


@runtime_checkable
class Scene(Protocol):
    """The optical bench that simulated devices and wire emulators share."""

    @property
    def clock(self) -> Clock:
        """Clock of every device on this bench."""
        ...

    def use_grid(self, grid: PixelGrid) -> None:
        """Take ``grid`` as the meaning of "px" from now on. It is called before the patterns of a run are loaded."""
        ...

    def truth(self, time_s: Floats) -> Truth:
        """Tell what the last run showed at ``time_s``, ``(frames,)`` seconds counted from its first sync edge."""
        ...


@runtime_checkable
class PlacesObject(Protocol):
    """What a scene may offer beside: where a stage will bring the object, before anything moves."""

    def object_boxes_px(self, grid: PixelGrid, stage_mm: Floats) -> Floats | None:
        """Tell where the object will be in a run whose first pattern finds the stage at the first of these positions.

        Args:
            grid: image grid of the run.
            stage_mm: ``(n,)`` positions of the stage.

        Returns:
            ``(n, 4)``: left, top, right and bottom edge of the object's image in px; the field reaches from -0.5 to image_size -
            0.5. None where the stage does not carry the object, or there is none.
        """
        ...
