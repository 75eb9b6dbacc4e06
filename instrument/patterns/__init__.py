"""Pattern synthesis: Fourier fringes made binary by dithering, Hadamard patterns in order, bits packed into bytes."""

from instrument.patterns.dither import floyd_steinberg
from instrument.patterns.fourier import fourier_pattern, fringe
from instrument.patterns.hadamard import HadamardOrder, hadamard_order, hadamard_signs, walsh_matrix
from instrument.patterns.moment import moment_pattern, ramp, saddle, saddle_pattern

__all__ = [
    "HadamardOrder",
    "floyd_steinberg",
    "fourier_pattern",
    "fringe",
    "hadamard_order",
    "hadamard_signs",
    "moment_pattern",
    "ramp",
    "saddle",
    "saddle_pattern",
    "walsh_matrix",
]
