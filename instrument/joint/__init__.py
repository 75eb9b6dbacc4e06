"""Path and image found together."""

from instrument.joint.agreement import position_misfit
from instrument.joint.grid import grid_of
from instrument.joint.lost_frame import LostFrame
from instrument.joint.refine import Refined, refine
from instrument.joint.turning import RefinedTurn, refine_turn

__all__ = ["LostFrame", "Refined", "RefinedTurn", "grid_of", "position_misfit", "refine", "refine_turn"]
