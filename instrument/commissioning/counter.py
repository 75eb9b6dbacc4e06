"""What can be measured of a counter with the modulator in front of it."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy.optimize import brentq

from instrument.commissioning.modulator import PICTURES
from instrument.commissioning.showing import (
    BETWEEN,
    DARK,
    STRIPES,
    WHITE,
    Counted,
    count_pictures,
    picture_time,
    sequence_of,
)
from instrument.session import Instrument
from protocols import Answer, Bytes, FigureValue, Floats, TimingFault

RUNS: Final = 5
"""Runs in a row at the highest rate."""

BRIGHT: Final = 7
"""Index of the bright picture among dark ones."""

DARK_PICTURES: Final = 500
"""Dark pictures, 2 ms each."""

_AMONG: Final = 32
"""Pictures of the play order in which one is bright."""

_SURE: Final = 5.0
"""Standard deviations from which on something is there."""

_SLOW_US: Final = 2000.0
"""Picture time in which weak light gives counts enough."""

_CYCLES: Final = 125
"""Times that dark, whole and both halves are shown."""

_CLOCKS_PPM: Final = 200.0
"""Difference of two crystals that is still one of crystals: 50 ppm each, and a margin."""


def pulses_edges_reads(bench: Instrument) -> Mapping[str, Answer]:
    """Five runs of dark pictures at the highest rate that modulator and counter share."""
    limits, counter = bench.modulator.limits, bench.counter.limits
    n = min(PICTURES, limits.play_order_entries - 1, counter.max_bins or PICTURES)
    timing = picture_time(limits, 1e6 / counter.max_sync_rate_hz)
    sequence = sequence_of(limits, [DARK], [0] * n)
    runs = [count_pictures(bench.modulator, bench.counter, bench.devices.clock, sequence, timing) for _ in range(RUNS)]
    return {"pulses": _pulses(runs), "edges": _edges(runs), "reads": _reads(runs)}


def order(bench: Instrument) -> Answer:
    """One white picture among dark ones: its bin must have its index."""
    dark_before = [0] * BRIGHT
    pictures = [*dark_before, 1, *([0] * (_AMONG - BRIGHT - 1))]
    n = min(_AMONG, bench.modulator.limits.play_order_entries - 1)
    values = _counted(bench, [DARK, WHITE], pictures[:n], times=4).values.reshape(4, n).sum(axis=0)
    others = np.delete(values, [BRIGHT, BRIGHT + 1])
    sigma = max(float(others.std(ddof=1)), float(np.sqrt(np.abs(others.mean()))), 1e-12)
    brightest = int(np.argmax(values))
    if values[brightest] - others.mean() <= _SURE * sigma:
        return Answer(
            said="no bin is brighter than the others: no light came to the detector, so the order is not known",
            doubts=("no light: open the shutter, align, and repeat",),
        )
    leak = float((values[BRIGHT + 1] - others.mean()) / (values[BRIGHT] - others.mean()))
    right = brightest == BRIGHT
    return Answer(
        said=f"picture {BRIGHT} is the bright one, and bin {brightest} is; "
        f"{100 * leak:.2f} % of its light is in the next bin, at {_SLOW_US:g} us a picture",
        figures={"bright_picture": BRIGHT, "bright_bin": brightest, "share_in_next_bin": leak},
        doubts=()
        if right
        else (f"bins are {brightest - BRIGHT:+d} from their pictures: see the counter's how-to for the first sample",),
    )


def dark(bench: Instrument) -> Answer:
    """One second of dark pictures."""
    n = min(DARK_PICTURES, bench.modulator.limits.play_order_entries - 1)
    light = _counted(bench, [DARK], [0] * n)
    values, period_s = light.values, light.period_s
    mean, scatter = float(values.mean()), float(values.std(ddof=1))
    if not light.photons:
        return Answer(
            said=f"{mean:.4g} with dark pictures, with a scatter of {scatter:.3g} from picture to picture, of 2 ms each",
            figures={"mean": mean, "scatter": scatter, "correlation_of_neighbours": _neighbours(values)},
        )
    stated, rate = bench.counter.limits.dark_rate_hz, mean / period_s
    return Answer(
        said=f"{rate:.4g} a second with dark pictures ({stated:.4g} stated): dark counts and what light the dark mirrors give",
        figures={"rate_hz": rate, "sigma_hz": scatter / np.sqrt(n) / period_s, "scatter_of_a_bin": scatter},
    )


def dead_time(bench: Instrument) -> Answer:
    """The light of two halves against the light of the whole: what is missing is the dead time (Knoll, chapter 4)."""
    limits = bench.counter.limits
    cycles = min(_CYCLES, (bench.modulator.limits.play_order_entries - 1) // 4)
    light = _counted(bench, [DARK, WHITE, STRIPES, BETWEEN], [0, 1, 2, 3] * cycles)
    values, period_s = light.values.reshape(cycles, 4), light.period_s
    none, whole, one, other = (float(rate) for rate in values.mean(axis=0) / period_s)
    sigmas = values.std(axis=0, ddof=1) / np.sqrt(cycles) / period_s
    sigma = float(np.linalg.norm(sigmas))
    share = (one + other - none) / whole if whole else 0.0
    figures: dict[str, FigureValue] = {
        "white_hz": whole,
        "half_hz": one,
        "other_half_hz": other,
        "dark_hz": none,
        "halves_over_whole": share,
    }
    if whole - none <= _SURE * sigma:
        return Answer(
            said="too little light to tell", figures=figures, doubts=("no light: open the shutter, and repeat",)
        )
    if limits.dead_time_s == 0:
        sure = abs(share - 1) < max(0.01, _SURE * sigma / whole)
        return Answer(
            said=f"two halves of the light together are {share:.4f} of the whole",
            figures=figures,
            doubts=() if sure else ("the detector is not linear: lower the light, or its gain",),
        )
    found_s = _dead_time_s(none, whole, one, other)
    if found_s is None:
        return Answer(
            said="the light of both halves is not that of the whole", figures=figures, doubts=("unsteady light",)
        )
    sigma_s = sigma / (whole**2 + none**2 - one**2 - other**2)
    if sigma_s > 0.3 * limits.dead_time_s:
        return Answer(
            said=f"too little light to tell: {1e9 * found_s:.0f} +- {1e9 * sigma_s:.0f} ns",
            figures={**figures, "sigma_s": sigma_s, "stated_s": limits.dead_time_s},
        )
    agrees = abs(found_s - limits.dead_time_s) < _SURE * sigma_s + 0.1 * limits.dead_time_s
    return Answer(
        said=f"dead time {1e9 * found_s:.2f} +- {1e9 * sigma_s:.2f} ns by two halves of the light; "
        f"{1e9 * limits.dead_time_s:.3g} ns stated",
        figures={**figures, "dead_time_s": found_s, "sigma_s": sigma_s, "stated_s": limits.dead_time_s},
        doubts=()
        if agrees
        else (
            "measured and stated dead time differ: measure with kinopix calibrate detector, which tells its kind too",
        ),
    )


def _dead_time_s(none: float, whole: float, one: float, other: float) -> float | None:
    """Non-paralyzable dead time with which the light of both halves is that of the whole; rates in 1/s."""

    def missing(tau_s: float) -> float:
        return sum(sign * m / (1 - m * tau_s) for sign, m in ((1, one), (1, other), (-1, whole), (-1, none)))

    edge_s = 0.9 / whole
    if missing(edge_s) * missing(-edge_s) > 0:
        return None
    return float(brentq(missing, -edge_s, edge_s))


@dataclass(frozen=True, eq=False)
class _Light:
    """Light of pictures that came whole."""

    values: Floats
    period_s: float
    photons: bool


def _counted(bench: Instrument, pictures: list[Bytes], play: list[int], times: int = 1) -> _Light:
    """Light of each picture of a slow play order, shown once or several times.

    Raises:
        TimingFault: a picture without its bin.
    """
    limits = bench.modulator.limits
    sequence = sequence_of(limits, pictures, play)
    timing = picture_time(limits, max(_SLOW_US, 1e6 / bench.counter.limits.max_sync_rate_hz))
    runs = [count_pictures(bench.modulator, bench.counter, bench.devices.clock, sequence, timing) for _ in range(times)]
    for run in runs:
        if len(run.values) != run.expected:
            raise TimingFault(
                device=bench.counter.identity.name,
                saw=f"{len(run.values)} bins of {run.expected} pictures, {run.period_s * 1e3:g} ms each",
                expected="one bin for each",
                remedy="look at the sync line with an oscilloscope: level, width, bounces",
            )
    return _Light(np.concatenate([run.values for run in runs]), runs[0].period_s, runs[0].photons)


def _neighbours(values: Floats) -> float:
    """Correlation of each value with the next: 0 for white noise."""
    rest = values - values.mean()
    power = float(rest @ rest)
    return float(rest[1:] @ rest[:-1]) / power if power else 0.0


def _pulses(runs: list[Counted]) -> Answer:
    n, rate = runs[0].expected, 1 / runs[0].period_s
    bins = tuple(float(len(run.values)) for run in runs)
    edges = tuple(float("nan") if run.report.edges_seen is None else float(run.report.edges_seen) for run in runs)
    known = [run for run in runs if run.report.edges_seen is not None]
    doubts: list[str] = [note for run in runs for note in run.report.notes[:1] if not run.whole]
    if not all(run.whole for run in runs):
        doubts.append(f"{n} pictures and the guard must give {n} bins and {n + 1} edges each time")
    whole = all(run.whole for run in runs)
    told = (
        "edges not told"
        if not known
        else f"{n + 1} edges"
        if whole
        else "edges " + ", ".join(f"{x:.0f}" for x in edges)
    )
    return Answer(
        said=f"{len(runs)} runs of {n} pictures and the guard at {rate:,.0f} a second: "
        f"bins {', '.join(f'{len(run.values)}' for run in runs)}; {told}; "
        f"first bin read {min(run.first_bin_s for run in runs):.3g} s after the start",
        figures={
            "rate_hz": rate,
            "pictures": n,
            "bins": bins,
            "edges": tuple(edge for edge in edges if np.isfinite(edge)),
            "first_bin_s": tuple(run.first_bin_s for run in runs),
        },
        doubts=tuple(doubts),
    )


def _edges(runs: list[Counted]) -> Answer:
    timed = [run.durations_s for run in runs if run.durations_s is not None]
    if not timed:
        return Answer(said="the counter gives no edge times")
    steps = np.concatenate(timed)
    period_s = runs[0].period_s
    ppm = 1e6 * (float(steps.mean()) / period_s - 1)
    return Answer(
        said=f"steps of the edges {1e6 * steps.mean():.6g} us in the mean, {1e9 * steps.std():.3g} ns scatter; the modulator's "
        f"clock is {ppm:+.1f} ppm from the counter's",
        figures={
            "mean_s": float(steps.mean()),
            "scatter_s": float(steps.std()),
            "longest_s": float(steps.max()),
            "ppm": ppm,
        },
        doubts=(f"{ppm:+.0f} ppm are more than two crystals differ by: is the clock's rate in bench.toml right?",)
        if abs(ppm) > _CLOCKS_PPM
        else (),
    )


def _reads(runs: list[Counted]) -> Answer:
    reads, bins = sum(run.reads for run in runs), sum(len(run.values) for run in runs)
    seconds, cpu_s = sum(run.reading_s for run in runs), sum(run.cpu_s for run in runs)
    return Answer(
        said=f"{reads / seconds:.3g} reads a second, {bins / max(1, reads):.3g} bins each, "
        f"{1e6 * cpu_s / max(1, bins):.3g} us of this computer's processor a bin",
        figures={
            "reads_per_s": reads / seconds,
            "bins_per_read": bins / max(1, reads),
            "cpu_s_per_bin": cpu_s / max(1, bins),
        },
    )
