"""What one frame shows and what its values say: one file a scheme, found by entry point."""

from instrument.config import SchemePlugin, SchemeSettings
from instrument.schemes.columns import Axis, Column, Role, in_play_order
from instrument.schemes.exchanged import AXES_EXCHANGED, exchanges
from instrument.schemes.fourier_hadamard import FourierHadamard, FourierHadamardSettings
from instrument.schemes.fringes import FringeSettings, fringe_patterns
from instrument.schemes.hadamard_pairs import DitheredSettings, HadamardSettings, hadamard_rows, pair_light, sequence_of
from instrument.schemes.observation import Light, Observation
from instrument.schemes.pictures import PicturesSettings
from instrument.schemes.ramps import Ramps
from instrument.schemes.reading import PositionReading, Signals, as_signals, fourier_reading, moment_reading
from instrument.schemes.scheme import ImageRows, Scheme, image_rows_of, position_of
from instrument.schemes.select import scheme_of
from instrument.schemes.turn import TurnReading

__all__ = [
    "AXES_EXCHANGED",
    "Axis",
    "Column",
    "DitheredSettings",
    "FourierHadamard",
    "FourierHadamardSettings",
    "FringeSettings",
    "HadamardSettings",
    "ImageRows",
    "Light",
    "Observation",
    "PicturesSettings",
    "PositionReading",
    "Ramps",
    "Role",
    "Scheme",
    "SchemePlugin",
    "SchemeSettings",
    "Signals",
    "TurnReading",
    "as_signals",
    "exchanges",
    "fourier_reading",
    "fringe_patterns",
    "hadamard_rows",
    "image_rows_of",
    "in_play_order",
    "moment_reading",
    "pair_light",
    "position_of",
    "scheme_of",
    "sequence_of",
]
