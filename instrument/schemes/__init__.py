"""What one frame shows and how its values decode."""

from instrument.schemes.fourier_hadamard import Decoded, FourierHadamard
from instrument.schemes.select import scheme_of

__all__ = ["Decoded", "FourierHadamard", "scheme_of"]
