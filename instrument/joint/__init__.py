"""Path and image found together."""

from instrument.joint.refine import Refined, refine

__all__ = ["Refined", "refine"]
