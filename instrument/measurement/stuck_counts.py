"""Counts that stand still: a saturated detector, or a counter that hangs, gives the same value for many patterns in a row.

Such values go with no pattern, and must not be taken for values that slipped to other patterns. A detector that saturates only at
bright patterns gives the same value for these, and others in between.
"""

from typing import Final

import numpy as np

from protocols import Floats, Mask

_IN_A_ROW: Final = 30
"""Equal values in a row from which on they stand still. A count of 1 has a probability of 0.37 at most, a higher one has less:
chance makes so many in one of 10^9 runs of 10,000 values."""

_LEVELS: Final = 2
"""Different values that the others have at most where they hardly vary."""

_LEAST: Final = 10.0
"""Photons below which many values are equal by chance."""

_OFTEN: Final = 0.01
"""Share of the values that are the highest of the run from which on the detector is taken to saturate."""

_MOSTLY: Final = 0.5
"""Share of the values of a pattern above which they are the highest by right, where there may be no noise."""

_FEWEST: Final = 20
"""Values that must be so at least."""


def stuck_counts(values: Floats, *, photon_counts: bool) -> Mask:
    """``(frames, patterns_per_frame)``: whether a value is one of many equal ones in a row.

    Zeros are darkness, and are left to ``dark_frames``. Values without noise may be alike by right, as those of patterns that all
    cut an even object in halves: there only the largest value of the run counts, at which a detector saturates. Where the other
    values hardly vary either, none is called stuck: nothing says what they should be.

    Args:
        values: ``(frames, patterns_per_frame)`` in play order; NaN where none was measured.
        photon_counts: whether they count photons.
    """
    flat = values.ravel()
    starts = np.flatnonzero(np.append(True, flat[1:] != flat[:-1]))
    lengths = np.diff(np.append(starts, flat.size))
    suspect = (lengths >= _IN_A_ROW) & (flat[starts] != 0)
    if not photon_counts:
        suspect &= flat[starts] == np.nanmax(np.append(flat, -np.inf))
    stuck = np.repeat(suspect, lengths)
    others = flat[~stuck & np.isfinite(flat)]
    varies = len(np.unique(others)) > _LEVELS
    return np.asarray(stuck.reshape(values.shape), bool) if varies else np.zeros(values.shape, bool)


def saturated(values: Floats, *, photon_counts: bool) -> Mask:
    """``(frames, patterns_per_frame)``: values that are all the highest of the run, as of a detector that saturates; none if few.

    A pattern that always gives that value tells nothing. Nor does one that mostly gives it, where values may be without noise: of
    an object at rest it does so by right. Light that is rounded so coarsely that many values are the highest by chance looks the
    same.

    Args:
        values: ``(frames, patterns_per_frame)``; NaN where none was measured.
        photon_counts: whether they count photons.
    """
    none, known = np.zeros(values.shape, bool), np.isfinite(values)
    highest = float(values[known].max(initial=0.0))
    if highest <= (_LEAST if photon_counts else 0.0):
        return none
    at_highest: Mask = np.asarray(values == highest, bool)
    mostly = (at_highest | ~known).all(axis=0) if photon_counts else at_highest.mean(axis=0) > _MOSTLY
    at_highest[:, mostly] = False
    return at_highest if np.count_nonzero(at_highest) >= max(_FEWEST, _OFTEN * np.count_nonzero(known)) else none
