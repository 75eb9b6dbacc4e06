"""Small sequences that fit every modulator, and what a counter makes of them."""

import time
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Final

import numpy as np

from protocols import (
    Bytes,
    Clock,
    CounterReport,
    CounterRun,
    Floats,
    ModulatorLimits,
    ModulatorTiming,
    PatternModulator,
    PatternSequence,
    PhotonCounter,
    PixelGrid,
)

SAMPLES: Final = 64
"""Side of a picture in samples; it is as high as the mirrors."""

PATIENCE_S: Final = 1.0
"""Time that edges and counts may take beyond the run."""

DARK: Final = np.zeros((SAMPLES, SAMPLES), np.uint8)
WHITE: Final = np.ones((SAMPLES, SAMPLES), np.uint8)
STRIPES: Final = np.repeat(np.arange(SAMPLES)[None] // 4 % 2, SAMPLES, axis=0).astype(np.uint8)
"""Sixteen stripes, every second one lit: about half of the light, wherever the object is."""

BETWEEN: Final = 1 - STRIPES
"""The other half."""


def sequence_of(limits: ModulatorLimits, pictures: Sequence[Bytes], order: Sequence[int]) -> PatternSequence:
    """Give a play order of ``pictures``, ``(64, 64)`` of 0 and 1 each, with the dark guard at its end."""
    planes = np.packbits(np.stack([*pictures, DARK]), axis=-1)
    grid = PixelGrid(
        image_size=SAMPLES,
        superpixel=min(limits.rows, limits.columns) // SAMPLES,
        columns=limits.columns,
        rows=limits.rows,
    )
    return PatternSequence(planes, np.append(np.asarray(order, np.int64), len(pictures)), grid, SAMPLES)


def picture_time(limits: ModulatorLimits, wanted_us: float) -> ModulatorTiming:
    """Give the timing with that picture time, or the nearest that the modulator has."""
    time_us = min(max(int(np.ceil(wanted_us)), limits.shortest_picture_time_us), limits.longest_picture_time_us)
    return ModulatorTiming(picture_time_us=time_us, sync_width_us=min(5, time_us - 1))


@dataclass(frozen=True, eq=False)
class Counted:
    """A play order as the counter saw it."""

    expected: int
    """Pictures without the guard."""

    period_s: float
    """Picture time, as the modulator keeps it."""

    values: Floats
    """``(n,)`` light of each bin."""

    photons: bool
    """Whether the values are counts."""

    durations_s: Floats | None
    """``(n,)`` length of each bin by the counter's clock; None without edge times."""

    report: CounterReport
    """What the counter said when it was disarmed."""

    first_bin_s: float
    """Time from the start of the modulator to the first bin that could be read, in seconds."""

    reads: int
    """Reads until all bins were in."""

    reading_s: float
    """Time that they took, on the bench's clock."""

    cpu_s: float
    """Processor time that they took."""

    @property
    def whole(self) -> bool:
        """Whether each picture gave one bin and one edge, and the guard the last edge."""
        return len(self.values) == self.expected and self.report.edges_seen in {None, self.expected + 1}


def count_pictures(
    modulator: PatternModulator,
    counter: PhotonCounter,
    clock: Clock,
    sequence: PatternSequence,
    timing: ModulatorTiming,
) -> Counted:
    """Play a sequence once and count it. Modulator and counter are at rest afterwards, whatever happens.

    Raises:
        KinopixError: of either device.
    """
    kept = modulator.load(sequence, timing)
    n, period_s = sequence.n_patterns, kept.picture_time_us * 1e-6
    values: list[Floats] = []
    edges: list[Floats] = []
    photons, got, reads, first_bin_s = True, 0, 0, float("nan")
    counter.arm(CounterRun(n_bins=n, n_expected=n, period_s=period_s))
    try:
        began_s, cpu_s = clock.now_s(), time.process_time()
        modulator.start()
        until_s = began_s + n * period_s + PATIENCE_S
        while got < n and clock.now_s() < until_s:
            block = counter.read(0.1)
            reads += 1
            if len(block):
                first_bin_s = clock.now_s() - began_s if not got else first_bin_s
                photons, got = block.photon_counts, got + len(block)
                values.append(block.counts.astype(np.float64))
                if block.opening_edge_s is not None and block.closing_edge_s is not None:
                    edges.append(np.diff(np.append(block.opening_edge_s, block.closing_edge_s)))
        reading_s, cpu_s = clock.now_s() - began_s, time.process_time() - cpu_s
        modulator.wait(period_s * (n + 1) + PATIENCE_S)
        clock.sleep_s(10 * period_s)  # for edges that should not be
    finally:
        try:
            modulator.halt()
        finally:
            report = counter.disarm()
    counts = np.concatenate(values) if values else np.empty(0)
    durations = np.concatenate(edges) if edges else None
    return Counted(n, period_s, counts, photons, durations, report, first_bin_s, reads, reading_s, cpu_s)
