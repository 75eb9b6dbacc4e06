"""Light of Hadamard patterns that is lost at the edges of their lit pixels, given back on average."""

import numpy as np

from instrument.schemes import Scheme, image_rows_of
from protocols import Floats, Integers, Mask


def bordering_share(pairs: Integers, size: int) -> Floats:
    """Give the light that a Hadamard pattern and its complement lose together, over the total, for an edge loss a side of 1.

    A pattern of c_i sign changes down and c_j across has c_i + c_j borders, each as long as the field. On both sides of a border
    there is a row of pixels, each of which is lit in one of the two patterns. Of light that is spread over the field they have
    the share 2 (c_i + c_j) / m.

    Args:
        pairs: ``(rows, 2)`` sign changes c_i and c_j of each pattern.
        size: pixels m a side of the field.

    Returns:
        ``(rows,)``.
    """
    return np.asarray(2 * pairs.sum(axis=1) / size, np.float64)


def with_edge_light(values: Floats, scheme: Scheme, size: int, edge_loss_a_side: float) -> Floats:
    """Give half of what a pair of Hadamard patterns lost to each of them: their sum is then that of an all-on pattern.

    What is lost depends on the pattern, and in ascending order on time: uncorrected, it looks like a lamp that fades.

    Args:
        values: ``(frames, patterns_per_frame)`` light.
        scheme: what was shown.
        size: pixels a side of the field.
        edge_loss_a_side: share of a pattern pixel's light that is lost at each side that borders a dark one.

    Returns:
        Values of the same shape.
    """
    if edge_loss_a_side == 0 or scheme.image_rows is None:
        return values
    rows = image_rows_of(scheme)
    lost = edge_loss_a_side * bordering_share(rows.pairs[np.arange(len(values)) % len(rows.pairs)], size)
    columns = [rows.positive, rows.negative]
    lost = _of_ramps(lost, values[:, columns].sum(axis=1), rows.is_ramp(np.arange(len(values))))
    given_back = values.copy()
    given_back[:, columns] += (values[:, columns].sum(axis=1) * lost / (1 - lost) / 2)[:, None]
    return given_back


def _of_ramps(lost: Floats, sums: Floats, ramp: Mask) -> Floats:
    """Give the share that each pair lost, ``(frames,)``, where ramps lost what their sums lack against those of the other pairs.

    A dithered ramp loses the more the nearer it is to grey, and so the object's place decides. A Hadamard pattern loses alike
    everywhere.
    """
    measured = np.isfinite(sums)
    first, others = ramp & measured, ~ramp & measured
    if not (first.any() and others.any()):
        return lost
    all_on = float(np.mean((sums / (1 - lost))[others][: np.count_nonzero(first)]))
    found = lost.copy()
    found[ramp] = 1 - float(sums[first].mean()) / all_on if all_on > 0 else 0.0
    return found
