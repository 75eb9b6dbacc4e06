"""What every section of a calibration file has."""

from typing import Annotated

from pydantic import AwareDatetime, Field

from protocols import Frozen


class Section(Frozen):
    """One calibration. A section of its own derives from this, or from ``GridSection``, and adds its numbers."""

    date: AwareDatetime
    """When it was measured."""


class GridSection(Section):
    """A calibration in image pixels, which holds for one size of them only."""

    image_size: Annotated[int, Field(gt=0, le=4096)]
    """Image pixels a side of the field that it was measured in."""

    superpixel: Annotated[int, Field(gt=0, le=4096)]
    """Mirrors a side of an image pixel."""
