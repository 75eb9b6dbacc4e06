"""Path and image found together."""

from instrument.joint.agreement import position_misfit
from instrument.joint.evidence import CONTRADICTS
from instrument.joint.expected import Explained
from instrument.joint.grid import grid_of
from instrument.joint.lost_frame import LostFrame
from instrument.joint.refine import Refined, refine
from instrument.joint.slipped import Placed, likeliest, placed
from instrument.joint.turning import RefinedTurn, refine_turn

__all__ = [
    "CONTRADICTS",
    "Explained",
    "LostFrame",
    "Placed",
    "Refined",
    "RefinedTurn",
    "grid_of",
    "likeliest",
    "placed",
    "position_misfit",
    "refine",
    "refine_turn",
]
