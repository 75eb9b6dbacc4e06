"""The settings of the paper's experiment that several studies share."""

from typing import Final

from instrument.studies.simulated import Simulated

EXPERIMENT: Final = Simulated(motion="uniform", peak_counts=250.0, height_px=23, corner_px=(6, 4))
"""A "B" 3.2 mm high at 7.2 px/mm, on the stage's diagonal at 25 mm/s, photons counted: 250 of an all-lit pattern, which is what
the paper's photomultiplier counts linearly in 50 us (5 million a second, data sheet of the H10682)."""
