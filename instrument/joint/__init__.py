"""Path and image found together."""

from instrument.joint.grid import grid_of
from instrument.joint.refine import Refined, refine

__all__ = ["Refined", "grid_of", "refine"]
