"""Path and image found together."""

from instrument.joint.grid import grid_of
from instrument.joint.refine import Refined, refine
from instrument.joint.turning import RefinedTurn, refine_turn

__all__ = ["Refined", "RefinedTurn", "grid_of", "refine", "refine_turn"]
