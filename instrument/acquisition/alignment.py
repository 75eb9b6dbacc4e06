"""From bins, in the order in which edges came, to patterns, in the order in which they were played.

A lost sync edge joins two bins, a surplus one splits a bin; from there on the n-th bin is no longer the n-th pattern.
Hardware edge times tell where: the step from edge to edge is a whole number of picture times. Steps are taken from edge to
edge and not from the start, so that the few ppm between the modulator's crystal and the counter's never add up to a pattern.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from protocols import CountBlock, CounterOverrun, Floats, Integers, Mask

EARLY: Final = 0.75
"""An edge sooner than this many periods after the last good one is surplus (a bounce)."""

LATE: Final = 1.25
"""A step longer than this many periods is irregular; from 1.5 on, edges are missing."""


@dataclass(frozen=True, eq=False)
class AlignedBlock:
    """Values of successive patterns in play order."""

    first_pattern: int
    """Index of the first pattern, from 0."""

    values: Floats
    """``(n,)``: NaN where a pattern has no bin of its own."""

    valid: Mask
    """``(n,)``: whether the pattern was counted alone and whole."""

    edge_time_s: Floats | None
    """``(n,)``: opening edge; NaN where it is missing; None without edge times."""

    gaps: Integers
    """Patterns whose opening edge is missing."""

    doubles: Integers
    """Patterns in which a surplus edge came."""

    irregular: Integers
    """Patterns whose length is off by more than a quarter period, though no edge is missing."""

    beyond: int = 0
    """Bins past the last pattern of the run, which have no place and are left out."""


_NONE = np.zeros(0, np.int64)


class Aligner:
    """Gives each bin its pattern, block after block, until the run has all its patterns."""

    def __init__(self, period_s: float, patterns: int) -> None:
        """Start at pattern 0.

        Args:
            period_s: picture time, as the modulator keeps it.
            patterns: patterns in the run; what comes after them is counted and left out.
        """
        self._period_s = period_s
        self._patterns = patterns
        self._next = 0
        self._bins = 0
        self._opened_s: float | None = None  # opening edge of a pattern that surplus edges have split so far
        self._carried = 0.0  # its light so far
        self._split = False
        self._timed = False  # whether blocks with edge times have come

    @property
    def patterns(self) -> int:
        """Patterns placed so far."""
        return min(self._next, self._patterns)

    def place(self, block: CountBlock) -> AlignedBlock:
        """Place the bins of the next block.

        A gap puts the joint light of the patterns on the first of them, invalid, and NaN on the others. Pieces that a surplus
        edge split are added up again, and the pattern is marked invalid all the same. Bins that come without edge times after
        others that had them are placed in order and marked invalid.

        Raises:
            CounterOverrun: the block does not begin where the one before ended, so that bins are missing or came twice.
                Nothing of it is placed; what was placed before stays good.
        """
        if block.first_bin != self._bins:
            raise _out_of_step(block, self._bins)
        self._bins += len(block)
        return self._within_run(self._placed(block))

    def _within_run(self, placed: AlignedBlock) -> AlignedBlock:
        first = min(placed.first_pattern, self._patterns)
        room = self._patterns - first
        beyond = len(placed.values) - room
        if beyond <= 0:
            return placed
        return replace(
            placed,
            first_pattern=first,
            values=placed.values[:room],
            valid=placed.valid[:room],
            edge_time_s=None if placed.edge_time_s is None else placed.edge_time_s[:room],
            gaps=placed.gaps[placed.gaps < self._patterns],
            doubles=placed.doubles[placed.doubles < self._patterns],
            irregular=placed.irregular[placed.irregular < self._patterns],
            beyond=beyond,
        )

    def _placed(self, block: CountBlock) -> AlignedBlock:
        counts = block.counts.astype(np.float64)
        if block.opening_edge_s is None or block.closing_edge_s is None or not len(block):
            return self._in_order(block, counts)
        self._timed = True
        edges = np.append(block.opening_edge_s, block.closing_edge_s)
        steps = np.diff(edges) / self._period_s
        if self._opened_s is None and bool(np.all((steps > EARLY) & (steps < LATE))):
            return self._in_order(block, counts)
        return self._step_by_step(edges, counts, block)

    def _in_order(self, block: CountBlock, counts: Floats) -> AlignedBlock:
        first, self._next = self._next, self._next + len(block)
        valid = np.ones(len(block), bool) if block.suspect is None else ~block.suspect
        if self._timed and block.opening_edge_s is None:
            valid = np.zeros(len(block), bool)
        return AlignedBlock(first, counts, valid, block.opening_edge_s, _NONE, _NONE, _NONE)

    def _step_by_step(self, edges: Floats, counts: Floats, block: CountBlock) -> AlignedBlock:
        first = self._next
        values: list[float] = []
        valid: list[bool] = []
        opened: list[float] = []
        gaps: list[int] = []
        doubles: list[int] = []
        irregular: list[int] = []
        suspect = np.zeros(len(counts), bool) if block.suspect is None else block.suspect
        for k, light in enumerate(counts.tolist()):
            open_s = float(edges[k]) if self._opened_s is None else self._opened_s
            step = (float(edges[k + 1]) - open_s) / self._period_s
            self._carried += light
            if step < EARLY:
                self._opened_s, self._split = open_s, True
                continue
            missing = max(1, round(step)) - 1
            here = first + len(values)
            if self._split:
                doubles.append(here)
            if missing:
                gaps.extend(range(here + 1, here + 1 + missing))
            elif step > LATE:
                irregular.append(here)
            good = not (self._split or missing or step > LATE or suspect[k])
            values += [self._carried, *[np.nan] * missing]
            opened += [open_s, *[np.nan] * missing]
            valid += [good, *[False] * missing]
            self._opened_s, self._carried, self._split = None, 0.0, False
        self._next = first + len(values)
        return AlignedBlock(
            first,
            np.array(values, np.float64),
            np.array(valid, bool),
            np.array(opened, np.float64),
            np.array(gaps, np.int64),
            np.array(doubles, np.int64),
            np.array(irregular, np.int64),
        )


def _out_of_step(block: CountBlock, expected: int) -> CounterOverrun:
    low, high = sorted((block.first_bin, expected))
    bins, verb = (f"bin {low}", "is") if high - low == 1 else (f"bins {low} to {high - 1}", "are")
    return CounterOverrun(
        device="counter",
        saw=f"a block that begins at bin {block.first_bin}: {bins} {f'{verb} missing' if low == expected else 'came again'}",
        expected=f"bin {expected}, where the block before ended",
        remedy="record again; if it comes back, run the conformance suite of the counter's driver",
    )
