"""Pattern synthesis: Fourier fringes made binary by dithering, Hadamard patterns in order, pictures by name."""

from instrument.patterns.dither import floyd_steinberg
from instrument.patterns.fourier import fourier_pattern, fringe
from instrument.patterns.hadamard import HadamardOrder, hadamard_order, hadamard_signs, walsh_matrix
from instrument.patterns.moment import moment_pattern, ramp, saddle, saddle_pattern
from instrument.patterns.picture_file import picture_of_file
from instrument.patterns.pictures import LETTER_WIDTH, PICTURES, letter, picture

__all__ = [
    "LETTER_WIDTH",
    "PICTURES",
    "HadamardOrder",
    "floyd_steinberg",
    "fourier_pattern",
    "fringe",
    "hadamard_order",
    "hadamard_signs",
    "letter",
    "moment_pattern",
    "picture",
    "picture_of_file",
    "ramp",
    "saddle",
    "saddle_pattern",
    "walsh_matrix",
]
