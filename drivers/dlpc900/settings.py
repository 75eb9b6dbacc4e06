"""What bench.toml can tell the driver."""

from pydantic import PositiveFloat

from drivers.dlpc900.encoding import ColourOrder
from protocols import Frozen


class Dlpc900Settings(Frozen):
    """The ``[modulator]`` table for ``driver = "dlpc900"``."""

    serial_number: str = ""
    """Serial number of the USB device; empty takes the first."""

    colour_order: ColourOrder = "rgb"
    """Order of the colour bytes in an image; sources contradict each other, so a test image must tell."""

    reply_s: PositiveFloat = 1.0
    """Longest wait for a reply, in seconds."""

    upload_bytes_per_s: PositiveFloat = 311_000.0
    """Rate of the upload, in bytes a second [I]: 24 random planes of 1920 x 1080 are said to take 20 s."""
