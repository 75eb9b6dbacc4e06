"""The values of a recording, counted again from its raw counts."""

from itertools import pairwise

import numpy as np

from instrument.acquisition.alignment import AlignedBlock, Aligner
from protocols import CountBlock, Floats


def recount(
    raw_counts: Floats, raw_edge_time_s: Floats, *, picture_time_s: float, patterns: int
) -> tuple[Floats, Floats]:
    """Put raw counts in their places again, as the run did.

    The edge that closed the last bin of a run is not recorded; it is taken to have come in time.

    Args:
        raw_counts: ``(n,)`` as they arrived.
        raw_edge_time_s: ``(n,)`` opening edge of each, s; NaN where the counter gave none.
        picture_time_s: as the modulator kept it.
        patterns: of the plan.

    Returns:
        Values and opening edges, ``(m,)`` each, in play order; NaN where there is none.

    Raises:
        ProtocolViolation: edge times that go back, which no run has recorded.
    """
    aligner = Aligner(picture_time_s, patterns)
    timed = np.isfinite(raw_edge_time_s)
    bounds = [0, *(np.flatnonzero(np.diff(timed)) + 1).tolist(), len(raw_counts)]
    placed = [
        aligner.place(_block(first, raw_counts[first:end], raw_edge_time_s[first : end + 1], picture_time_s))
        for first, end in pairwise(bounds)
        if end > first
    ]
    if not placed:
        return np.empty(0), np.empty(0)
    return np.concatenate([block.values for block in placed]), np.concatenate([_edges(block) for block in placed])


def _block(first: int, counts: Floats, edges: Floats, period_s: float) -> CountBlock:
    """One stretch of bins that all have edge times, or have none; ``edges`` goes on by one where there is a next bin."""
    if not np.isfinite(edges[0]):
        return CountBlock(first, counts)
    opening = edges[: len(counts)]
    known = len(edges) > len(counts) and bool(np.isfinite(edges[-1]))
    return CountBlock(first, counts, opening, float(edges[-1] if known else opening[-1] + period_s))


def _edges(block: AlignedBlock) -> Floats:
    return np.full(len(block.values), np.nan) if block.edge_time_s is None else block.edge_time_s
