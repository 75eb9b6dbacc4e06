"""What other programs have recorded, as recordings of ours, and what is missing in them."""

from instrument.foreign.arrays import read_array
from instrument.foreign.convert import Converted, convert
from instrument.foreign.pairs import HadamardPairs
from instrument.foreign.spas import is_spas, read_spas

__all__ = ["Converted", "HadamardPairs", "convert", "is_spas", "read_array", "read_spas"]
