"""What an analysis is asked for: a value that names it, so that what is done can be told from what is not."""

import hashlib
from typing import Any

from instrument.choices import Background, Grid, Method, Normalise, Reach, Shape, Tracking
from instrument.storage import program
from protocols import Frozen


class Request(Frozen):
    """How recordings are to be analysed; the same for all of a series. The settings are those of ``analyse``."""

    tracking: Tracking = "joint"
    """Method by which the path is found."""

    method: Method = "tv"
    """Method by which the image is made."""

    frames: int | None = None
    """Number of frames, from the first on, that are used; None for all."""

    background: Background = "auto"
    """Whether the light of something that stands still is found together with the object."""

    background_file: str | None = None
    """Recording of the same plan without the object, to be subtracted; as this computer calls it."""

    grid: Grid = "auto"
    """Image pixels that a pattern pixel has along each axis."""

    mean_filter: int | None = None
    """Neighbouring coefficients that are averaged; for the tracking ``per-frame``."""

    normalise: Normalise = "auto"
    """By what values are divided."""

    shape: Shape = "auto"
    """Whether a slow change of the object's shape is found with its path."""

    region: Reach = "auto"
    """Whether the object is inside the field, or passes by, or that is found out."""

    @property
    def key(self) -> str:
        """Digest of the settings and of the program: an analysis that carries it need not be made again."""
        return hashlib.sha256(f"{program()}\n{self.model_dump_json()}".encode()).hexdigest()[:32]

    @property
    def settings(self) -> dict[str, Any]:
        """Give the arguments that ``analyse`` takes."""
        names = ("tracking", "method", "background", "grid", "mean_filter", "normalise", "shape", "region")
        return {name: getattr(self, name) for name in names}
