"""The ``[alignment]`` section of a calibration file: how the image lies, and which way the stage goes in it."""

from typing import Annotated, Final, Literal, TypeAlias, get_args

from pydantic import Field

from instrument.config.calibration_section import Section
from instrument.config.detector_section import Measured

Orientation: TypeAlias = Literal[
    "upright",
    "turned 90",
    "turned 180",
    "turned 270",
    "mirrored",
    "mirrored, turned 90",
    "mirrored, turned 180",
    "mirrored, turned 270",
]
"""How an image lies: mirrored left to right first, if at all, and then turned clockwise by so many degrees."""

ORIENTATIONS: Final[tuple[Orientation, ...]] = get_args(Orientation)
"""All eight."""


def upright_angle_deg(angle_deg: float, orientation: Orientation) -> float:
    """Give the direction that a direction in the image (from x towards y) has when the image is turned upright, -180 to 180."""
    way = ORIENTATIONS.index(orientation)
    turned = angle_deg - 90 * (way % 4)
    if way >= 4:
        turned = 180 - turned
    return (turned + 180) % 360 - 180


class AlignmentSection(Section):
    """How the target lay in the image, and what the stage did to it."""

    orientation: Orientation
    """How the image lies against the object as a person sees it."""

    turn_deg: Measured
    """Turn beyond that, clockwise as one looks at the picture; as uncertain as one pixel over the target's height."""

    certainty: Annotated[float, Field(ge=0)]
    """Log-likelihood by which the orientation is better than the next."""

    wiring: Literal["as planned", "H- first", "inverted"]
    """Whether patterns come as planned, H- before H+, or all as their complements."""

    target_height_px: Annotated[float, Field(gt=0)]
    """Height of the target in image pixels."""

    image_size: Annotated[int, Field(gt=0)]
    """Image pixels a side of the field that it was seen in."""

    superpixel: Annotated[int, Field(gt=0)]
    """Mirrors a side of a pixel."""

    axis_angle_deg: Measured | None = None
    """Direction of positive travel in the image, from x (right) towards y (down); None where the stage was not moved."""

    px_per_mm: Measured | None = None
    """Image pixels a millimetre of travel, coarsely: `kinopix calibrate displacement` measures it well."""

    axis_angle_upright_deg: float | None = None
    """The same direction in the image when it is turned upright."""
