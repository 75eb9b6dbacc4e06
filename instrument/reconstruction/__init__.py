"""The image of an object that moved: structured rows, total variation, ghost imaging, inverse transform."""

from instrument.reconstruction.conventional import inverse_hadamard
from instrument.reconstruction.dgi import ghost_image
from instrument.reconstruction.operator import Operator, ShiftedHadamard, Weighted
from instrument.reconstruction.reconstruct import Method, Reconstruction, reconstruct
from instrument.reconstruction.region import Region
from instrument.reconstruction.tv import TvState, total_variation
from instrument.reconstruction.tval3 import AlState, tv_augmented_lagrangian

__all__ = [
    "AlState",
    "Method",
    "Operator",
    "Reconstruction",
    "Region",
    "ShiftedHadamard",
    "TvState",
    "Weighted",
    "ghost_image",
    "inverse_hadamard",
    "reconstruct",
    "total_variation",
    "tv_augmented_lagrangian",
]
