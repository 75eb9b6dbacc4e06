"""Reconstruction of an object that moved: structured rows, total variation, ghost imaging, inverse transform."""

from instrument.choices import Method
from instrument.reconstruction.conventional import inverse_hadamard
from instrument.reconstruction.correlation import FixedPatterns
from instrument.reconstruction.dgi import ghost_image
from instrument.reconstruction.field import Field, hadamard_values
from instrument.reconstruction.methods import METHODS, ImageMethod, Solution, Solver, method_of, solution_of
from instrument.reconstruction.problem import Places, Problem
from instrument.reconstruction.reconstruct import Reconstruction, binned, field_in, light_for, reconstruct
from instrument.reconstruction.region import Region
from instrument.reconstruction.shifted_hadamard import ShiftedHadamard
from instrument.reconstruction.solved import solved
from instrument.reconstruction.turned_hadamard import DenseRows, TurnedRows
from instrument.reconstruction.walsh_rows import walsh_changes, walsh_rows

__all__ = [
    "METHODS",
    "DenseRows",
    "Field",
    "FixedPatterns",
    "ImageMethod",
    "Method",
    "Places",
    "Problem",
    "Reconstruction",
    "Region",
    "ShiftedHadamard",
    "Solution",
    "Solver",
    "TurnedRows",
    "binned",
    "field_in",
    "ghost_image",
    "hadamard_values",
    "inverse_hadamard",
    "light_for",
    "method_of",
    "reconstruct",
    "solution_of",
    "solved",
    "walsh_changes",
    "walsh_rows",
]
