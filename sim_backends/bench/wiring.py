"""Patterns that are shown where others should be."""

import numpy as np

from protocols import Integers
from sim_backends.bench.settings import SwappedPatterns


def wired(play_order: Integers, swap: SwappedPatterns | None, late: int) -> Integers:
    """Give the play order as it comes out of wrong memory or wrong wiring.

    Args:
        play_order: ``(pictures,)`` plane of each picture, the guard last.
        swap: two places of each whole frame to exchange.
        late: picture times by which patterns follow their edges; where none is left, the guard is shown.
    """
    if swap is None and not late:
        return play_order
    order = play_order.copy()
    if swap is not None:
        starts = np.arange((len(order) - 1) // swap.patterns_per_frame) * swap.patterns_per_frame
        one, other = starts + swap.first, starts + swap.second
        order[one], order[other] = play_order[other], play_order[one]
    shown_from = np.arange(len(order)) - late
    guard = len(order) - 1
    return order[np.where((shown_from >= 0) & (shown_from < guard), shown_from, guard)]
