"""The sync edges that every counter on the bench sees, faults and all."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from protocols import Floats
from sim_backends.bench.fault_settings import DoubledEdge, DroppedEdge, Fault, Stall, SurplusEdges


@dataclass(frozen=True, eq=False)
class SyncLine:
    """The seen edges of one projection."""

    phase: Floats
    """``(edges,)`` time of each edge in picture times after the start of picture 0. Whole numbers on a perfect line, so
    that a bin is exactly one picture."""

    stalls_at: int | None
    """The picture on which the modulator stays for ever, or None."""


def sync_line(
    pictures: int,
    *,
    picture_time_s: float,
    delay_s: float = 0.0,
    jitter_s: float = 0.0,
    seed: int = 0,
    faults: Iterable[Fault] = (),
) -> SyncLine:
    """Work out every edge of a projection before it starts.

    Args:
        pictures: entries of the play order, the guard included: so many edges on a perfect line.
        picture_time_s: from one picture to the next.
        delay_s: from an edge to the picture that it announces.
        jitter_s: standard deviation of each edge.
        seed: of the jitter.
        faults: what goes wrong. A fault at a picture that the run does not have does nothing.
    """
    faults = tuple(faults)
    stalls = [fault.picture for fault in faults if isinstance(fault, Stall) and fault.picture < pictures]
    stalls_at = min(stalls, default=None)
    shown = pictures if stalls_at is None else stalls_at + 1
    surplus = sum(fault.edges for fault in faults if isinstance(fault, SurplusEdges)) if stalls_at is None else 0
    phase = np.arange(shown + surplus, dtype=np.float64) - delay_s / picture_time_s
    if jitter_s:
        phase += np.random.default_rng([seed, 7]).standard_normal(len(phase)) * jitter_s / picture_time_s
    echoes = [
        phase[fault.picture] + fault.after_s / picture_time_s
        for fault in faults
        if isinstance(fault, DoubledEdge) and fault.picture < shown
    ]
    dropped = [fault.picture for fault in faults if isinstance(fault, DroppedEdge) and fault.picture < shown]
    if dropped or echoes:  # a line without them is not copied: it has as many edges as the run has patterns
        phase = np.concatenate([np.delete(phase, dropped), np.array(echoes)])
    phase.sort()
    return SyncLine(phase, stalls_at)


def overlap(begin: Floats, end: Floats, first_picture: int, value: Floats) -> Floats:
    """Integrate a value that is constant over each picture from ``begin`` to ``end``, in picture times.

    Args:
        begin: ``(n,)``.
        end: ``(n,)``, not before ``begin``.
        first_picture: picture of ``value[0]``; beyond ``value`` all is dark.
        value: ``(pictures,)``.
    """
    first = np.floor(begin)
    total = np.zeros(len(begin))
    for step in range(math.ceil(float((end - first).max(initial=0.0)))):
        picture = first + step
        part = np.clip(np.minimum(end, picture + 1) - np.maximum(begin, picture), 0.0, None)
        index = picture.astype(np.int64) - first_picture
        here = (index >= 0) & (index < len(value))
        total += np.where(here, value[np.where(here, index, 0)] * part, 0.0)
    return total
