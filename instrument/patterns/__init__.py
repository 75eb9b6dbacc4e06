"""Pattern synthesis: Fourier fringes made binary by dithering, Hadamard patterns in order, bits packed into bytes."""

from instrument.patterns.dither import floyd_steinberg
from instrument.patterns.fourier import fourier_pattern, fringe
from instrument.patterns.hadamard import hadamard_order, hadamard_signs, walsh_matrix

__all__ = ["floyd_steinberg", "fourier_pattern", "fringe", "hadamard_order", "hadamard_signs", "walsh_matrix"]
