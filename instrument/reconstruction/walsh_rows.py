"""Walsh rows as a moved object sees them: written out, and by their sign changes.

Row c of the Walsh matrix, zero outside the field, is a step function w of place. A pixel u of an object moved by d covers the
place from u + d to u + d + 1, and sees the mean of w there: linear interpolation between two entries, exact for square pixels.
"""

from functools import lru_cache

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.sparse import csr_array

from instrument.patterns import walsh_matrix
from protocols import Floats, Integers, Singles


def walsh_rows(
    size: int, number: Integers, place_px: Floats, first_px: int, count: int, *, slope: bool = False
) -> Singles:
    """Write rows out: entry u of a row is w(u + d).

    Args:
        size: pixels a side of the field.
        number: ``(rows,)``: which Walsh row, by its sign changes.
        place_px: ``(rows,)`` d.
        first_px: u of the first entry wanted.
        count: entries wanted.
        slope: give the derivative by d instead.

    Returns:
        ``(rows, count)``.
    """
    padding = size + 1
    whole = np.floor(place_px)
    fraction = (place_px - whole).astype(np.float32)[:, None]
    start = np.clip(whole.astype(np.int64) + first_px + padding, 0, size + 2 * padding - count - 1)
    window = sliding_window_view(_padded(size), count + 1, axis=1)[number, start]
    near, far = window[:, :-1], window[:, 1:]
    rows = far - near if slope else near + fraction * (far - near)
    return rows.astype(np.float32, copy=False)


def walsh_changes(size: int, number: Integers, place_px: Floats, first_px: int, count: int) -> csr_array:
    """Write rows as sparse weights of a cumulative sum.

    With C[u] the sum of entries 0 to u, the product of a row with a series is the sum of -(step of w at p) C(p - d - 1) over the
    places p where w changes, C read by linear interpolation, 0 before its start and constant after its end.

    Args:
        size: as in ``walsh_rows``, as the others.
        number: which rows.
        place_px: d of each.
        first_px: u of the series' first entry.
        count: its length.

    Returns:
        ``(rows, count)``: so few entries as the row has changes, twice.
    """
    steps = _steps(size)[number]
    row = np.repeat(np.arange(len(number)), np.diff(steps.indptr))
    whole = np.floor(place_px)
    fraction = (place_px - whole)[row]
    after = steps.indices - whole.astype(np.int64)[row] - first_px  # entries of the series before the change
    weights = np.concatenate([-steps.data * (1 - fraction), -steps.data * fraction])
    entries = np.clip(np.concatenate([after, after - 1]), 0, count)
    whole_sum = csr_array((weights, (np.tile(row, 2), entries)), shape=(len(number), count + 1))
    changes = csr_array(whole_sum[:, 1:])
    changes.sum_duplicates()
    return changes


@lru_cache(maxsize=4)
def _padded(size: int) -> Singles:
    return np.pad(walsh_matrix(size).astype(np.float32), ((0, 0), (size + 1, size + 1)))


@lru_cache(maxsize=4)
def _steps(size: int) -> csr_array:
    """``(size, size + 1)``: step of each row at place 0, 1, ... size; at both ends from and to 0."""
    return csr_array(np.diff(np.pad(walsh_matrix(size).astype(np.float64), ((0, 0), (1, 1))), axis=1))
