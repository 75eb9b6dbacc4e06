"""Walsh rows as a moved object sees them: written out, or by their sign changes.

Row c of the Walsh matrix, continued by 0 outside the field, is a step function w of position. Pixel u of an object that moved by
d covers the positions from u + d to u + d + 1, and sees the mean of w there. That is linear interpolation between two entries,
which is exact for square pixels.
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
    """Give shifted rows as an array; entry u of a row is the mean of w from u + d to u + d + 1.

    Args:
        size: pixels a side of the field.
        number: ``(rows,)`` index of each Walsh row, which is its number of sign changes.
        place_px: ``(rows,)`` displacement d.
        first_px: u of the first entry.
        count: number of entries.
        slope: whether to give the derivative by d, in 1/px, instead.

    Returns:
        The rows, ``(rows, count)``.
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
    """Give shifted rows as sparse weights of the cumulative sum of a series.

    Let C[u] be the sum of the series' entries 0 to u, C(u) its linear interpolation, 0 before the start and constant after the
    end. The product of a row with the series is the sum of -(step of w at p) C(p - d - 1) over the positions p where w changes.

    Args:
        size: pixels a side of the field.
        number: ``(rows,)`` index of each Walsh row.
        place_px: ``(rows,)`` displacement d.
        first_px: u of the first entry of the series.
        count: length of the series.

    Returns:
        The weights, ``(rows, count)``, with two entries for each change of a row.
    """
    steps = _steps(size)[number]
    row = np.repeat(np.arange(len(number)), np.diff(steps.indptr))
    whole = np.floor(place_px)
    fraction = (place_px - whole)[row]
    after = steps.indices - whole.astype(np.int64)[row] - first_px  # number of entries before the change
    weights = np.concatenate([-steps.data * (1 - fraction), -steps.data * fraction])
    entries = np.clip(np.concatenate([after, after - 1]), 0, count)
    with_empty_sum = csr_array((weights, (np.tile(row, 2), entries)), shape=(len(number), count + 1))
    changes = csr_array(with_empty_sum[:, 1:])
    changes.sum_duplicates()
    return changes


@lru_cache(maxsize=4)
def _padded(size: int) -> Singles:
    """Give the Walsh rows, ``(size, 3 size + 2)``, with size + 1 zeros on both sides."""
    return np.pad(walsh_matrix(size).astype(np.float32), ((0, 0), (size + 1, size + 1)))


@lru_cache(maxsize=4)
def _steps(size: int) -> csr_array:
    """Give the steps, ``(size, size + 1)``, of each Walsh row at the positions 0 to size: first from 0, last to 0."""
    return csr_array(np.diff(np.pad(walsh_matrix(size).astype(np.float64), ((0, 0), (1, 1))), axis=1))
