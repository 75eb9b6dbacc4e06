"""Walsh rows as a moved object sees them: written out, or by their sign changes.

Row c of the Walsh matrix as it acts (see ``field``), continued by 0 outside the field, is a step function w of position. Pixel u
of an object that moved by d covers the positions from u + d to u + d + 1, and sees the mean of w there. That is linear
interpolation between two entries, which is exact for square pixels. On a finer grid all of that holds in units of its pixels.
"""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from scipy.sparse import csr_array

from instrument.reconstruction.field import Field, padded_walsh, walsh_steps
from protocols import Floats, Integers, Singles


def walsh_rows(
    field: Field, number: Integers, place_px: Floats, first_px: int, count_px: int, *, slope: bool = False
) -> Singles:
    """Give shifted rows as an array; entry u of a row is the mean of w over pixel u.

    Args:
        field: field and grid.
        number: ``(rows,)`` index of each Walsh row, which is its number of sign changes.
        place_px: ``(rows,)`` displacement d.
        first_px: pattern pixel at which the first entry begins.
        count_px: length of the rows, in pattern pixels.
        slope: whether to give the derivative by d, in 1/px, instead.

    Returns:
        The rows, ``(rows, count_px grid)``.
    """
    place, first, count = place_px * field.grid, first_px * field.grid, count_px * field.grid
    padding = max(field.pixels, count) + 1
    whole = np.floor(place)
    fraction = (place - whole).astype(np.float32)[:, None]
    start = np.clip(whole.astype(np.int64) + first + padding, 0, field.pixels + 2 * padding - count - 1)
    window = sliding_window_view(padded_walsh(field, padding), count + 1, axis=1)[number, start]
    near, far = window[:, :-1], window[:, 1:]
    rows = (far - near) * np.float32(field.grid) if slope else near + fraction * (far - near)
    return rows.astype(np.float32, copy=False)


def walsh_changes(field: Field, number: Integers, place_px: Floats, first_px: int, count_px: int) -> csr_array:
    """Give shifted rows as sparse weights of the cumulative sum of a series.

    Let C[u] be the sum of the series' entries 0 to u, C(u) its linear interpolation, 0 before the start and constant after the
    end. The product of a row with the series is the sum of -(step of w at p) C(p - d - 1) over the positions p where w changes.

    Args:
        field: field and grid.
        number: ``(rows,)`` index of each Walsh row.
        place_px: ``(rows,)`` displacement d.
        first_px: pattern pixel at which the series begins.
        count_px: length of the series, in pattern pixels.

    Returns:
        The weights, ``(rows, count_px grid)``, with two entries for each change of a row.
    """
    place, first, count = place_px * field.grid, first_px * field.grid, count_px * field.grid
    steps = walsh_steps(field)[number]
    row = np.repeat(np.arange(len(number)), np.diff(steps.indptr))
    whole = np.floor(place)
    fraction = (place - whole)[row]
    after = steps.indices - whole.astype(np.int64)[row] - first  # number of entries before the change
    weights = np.concatenate([-steps.data * (1 - fraction), -steps.data * fraction])
    entries = np.clip(np.concatenate([after, after - 1]), 0, count)
    with_empty_sum = csr_array((weights, (np.tile(row, 2), entries)), shape=(len(number), count + 1))
    changes = csr_array(with_empty_sum[:, 1:])
    changes.sum_duplicates()
    return changes
