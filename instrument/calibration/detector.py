"""Dark counts, dead time and its kind, linear limit, flicker of the lamp."""

from dataclasses import dataclass
from datetime import UTC, datetime
from itertools import pairwise
from typing import Final

import numpy as np

from instrument.calibration.dead_time import CERTAIN, DeadTimeFit, LightLadder, better
from instrument.calibration.pictures import PictureCounts, PictureField, counts_of, together
from instrument.config import DeadTimeKind, DetectorSection, LampLine, Measured
from instrument.measurement import ripples_seen
from instrument.recording import Recording
from instrument.session import Instrument
from protocols import InputError

LINEAR_LOSS: Final = 0.1
"""Share of the photons that is not counted at the linear limit, as data sheets have it."""

PARTS: Final = 8
"""Parts into which the field is cut, of about the same light."""

LADDER_HZ: Final = 500.0
"""Pictures a second of the ladder: five of them are a period of light on the mains, and transitions of mirrors are short."""

_EACH: Final = 5
_LOOK_S: Final = 2.0
_PIECE_S: Final = 10.0
_STRIPES: Final = 32
_TOO_DIM_HZ: Final = 1000.0
_CERTAIN_LIGHT: Final = 5.0
_MAINS_HZ: Final = (50.0, 60.0)
_NEAR_HZ: Final = 0.5
_SURE: Final = 3.0
_WEIGHTS: Final = {PARTS: 3, PARTS // 2: 2, PARTS // 4: 1, 1: 1}
"""How often pictures of so many parts stand in a cycle: the bright ones tell the most, and there are few of them."""


@dataclass(frozen=True)
class DetectorResult:
    """What was found."""

    section: DetectorSection
    """For the calibration file."""

    white_counts: float
    """Counts of the white picture at the rate of the runs to come."""

    doubts: tuple[str, ...] = ()
    """What a person should know before trusting it."""

    def filter_density(self, wanted_counts: float) -> float:
        """Optical density of the filter to add for ``wanted_counts`` in a white picture; negative: so much less of a filter."""
        return float(np.log10(max(self.white_counts, 1e-9) / wanted_counts))


def calibrate_detector(
    bench: Instrument,
    field: PictureField,
    *,
    pattern_rate_hz: float = 20_000.0,
    dark_s: float = 5.0,
    longest_s: float = 120.0,
    flicker_s: float = 3.0,
    shutter_closed: bool = False,
) -> DetectorResult:
    """Measure the detector with pictures of known parts.

    Args:
        bench: open, with modulator and counter.
        field: of the pictures, and where the runs are kept.
        pattern_rate_hz: of the runs to come, for the spectrum of the lamp and the counts of a white picture.
        dark_s: how long a black picture is counted.
        longest_s: how long the ladder is counted at most; it ends when the kind of the dead time is certain.
        flicker_s: how long a white picture is counted for the spectrum of the lamp.
        shutter_closed: whether no light comes to the detector: then dark counts alone are measured.

    Raises:
        InputError: there is no light, or too little of the field is lit.
        KinopixError: as ``Instrument.run``.
    """
    dark = counts_of(
        field.record(bench, "detector-dark", ["black"], seconds=dark_s, pattern_rate_hz=LADDER_HZ), each=1, settle=0
    )
    dark_rate = Measured(value=float(dark.rate_hz[0]), sigma=float(dark.sigma_hz[0]))
    section = DetectorSection(date=datetime.now(UTC), dark_rate_hz=dark_rate, shutter_closed=shutter_closed)
    if shutter_closed:
        return DetectorResult(section, 0.0)
    lines, white_counts = _flicker(
        field.record(bench, "detector-flicker", ["white"], seconds=flicker_s, pattern_rate_hz=pattern_rate_hz)
    )
    borders = _parts(bench, field)
    fit, between, brightest_hz = _climb(bench, field, borders, longest_s)
    # Light that excludes neither no dead time nor what the counter states tells nothing, and must not replace the latter.
    stated_s = bench.counter.limits.dead_time_s
    told = any(abs(fit.dead_time_s - tau_s) > _SURE * fit.sigma_s for tau_s in (0.0, stated_s))
    found = section.model_copy(
        update={
            "dead_time_s": Measured(value=max(0.0, fit.dead_time_s), sigma=fit.sigma_s) if told else None,
            "dead_time_kind": fit.kind if told and between >= CERTAIN and fit.dead_time_s > 0 else None,
            "chi_square_between": between,
            "linear_limit_hz": linear_limit_hz(fit.dead_time_s, fit.kind) if told and fit.dead_time_s > 0 else None,
            "brightest_hz": brightest_hz,
            "flicker": lines,
        }
    )
    return DetectorResult(found, white_counts, tuple(_doubts(fit, between, brightest_hz)))


def linear_limit_hz(dead_time_s: float, kind: DeadTimeKind) -> float:
    """Counts a second at which ``LINEAR_LOSS`` of the photons is not counted.

    m / n = 0.9 is at n tau = 1/9 or -ln 0.9, so at m tau = 0.1 or -0.9 ln 0.9 = 0.0948.
    """
    kept = 1 - LINEAR_LOSS
    return float((LINEAR_LOSS if kind == "non-paralyzable" else -kept * np.log(kept)) / dead_time_s)


def name_of_line(frequency_hz: float, pattern_rate_hz: float) -> str:
    """Say what makes a line in the spectrum of the light, as far as its frequency tells."""
    for mains_hz in _MAINS_HZ:
        for times in (2, 4, 6, 1):
            if abs(frequency_hz - times * mains_hz) < _NEAR_HZ * times:
                return f"{times} times the mains of {mains_hz:g} Hz" if times > 1 else f"the mains of {mains_hz:g} Hz"
    return f"a switching supply: its frequency is {frequency_hz:.0f} Hz, or that away from a multiple of {pattern_rate_hz:.0f} Hz"


def _flicker(recording: Recording) -> tuple[tuple[LampLine, ...], float]:
    """Lines in the light of a white picture, and its mean counts."""
    values = recording.values[:, 0]
    rate_hz = 1 / recording.picture_time_s
    ripples = ripples_seen(values, None, recording.frame_valid, recording.pattern_time_s[:, 0])
    lines = tuple(
        LampLine(
            frequency_hz=ripple.frequency_hz,
            amplitude=ripple.amplitude,
            name=name_of_line(ripple.frequency_hz, rate_hz),
        )
        for ripple in ripples
    )
    return lines, float(np.nanmean(values[recording.frame_valid]))


def _parts(bench: Instrument, field: PictureField) -> list[int]:
    """Borders of ``PARTS`` parts of about the same light, in px, by a look at stripes across the field."""
    edges = np.unique(np.linspace(0, field.image_size, _STRIPES + 1).round().astype(int))
    show = [f"columns:{a}-{b}" for a, b in pairwise(edges.tolist())]
    recording = field.record(
        bench, "detector-look", [*show, "black"], seconds=_LOOK_S, pattern_rate_hz=LADDER_HZ, each=_EACH
    )
    counts = counts_of(recording, _EACH)
    more_hz = counts.rate_hz[:-1] - counts.rate_hz[-1]
    sigma_hz = np.hypot(np.sqrt((counts.sigma_hz[:-1] ** 2).sum()), len(more_hz) * counts.sigma_hz[-1])
    if more_hz.sum() < (least_hz := max(_TOO_DIM_HZ, _CERTAIN_LIGHT * float(sigma_hz))):
        raise InputError(
            device="counter",
            saw=f"{more_hz.sum():.0f} counts/s more in lit pictures than in black ones",
            expected=f"{least_hz:.0f} or more",
            remedy="switch the lamp on and open the shutter; for dark counts alone say --shutter-closed",
        )
    light_hz = np.maximum(more_hz, 0.0)
    share = np.concatenate([[0.0], np.cumsum(light_hz)]) / light_hz.sum()
    inner = np.interp(np.arange(1, PARTS) / PARTS, share, edges).round().astype(int)
    borders = [0, *inner.tolist(), field.image_size]
    for k in range(1, PARTS):  # each part is a px wide or more
        borders[k] = min(max(borders[k], borders[k - 1] + 1), field.image_size - (PARTS - k))
    return borders


def _climb(
    bench: Instrument, field: PictureField, borders: list[int], longest_s: float
) -> tuple[DeadTimeFit, float, float]:
    """Count a ladder piece by piece until the kind of the dead time is certain, or the time is over."""
    spans = [(k, k + width) for width in (1, 2, 4, 8) for k in range(0, PARTS, width)]
    upward = [span for span in spans for _ in range(_WEIGHTS[span[1] - span[0]])]
    names = [f"columns:{borders[a]}-{borders[b]}" for a, b in upward]
    half = [*names, "checker:1", "not checker:1", "black"]
    show = [*half, *reversed(half)]  # there and back, so that a lamp that drifts changes all by the same
    lit = np.array([[a <= k < b for k in range(PARTS)] for a, b in [*upward, (0, 0)]])
    width_mirrors = np.diff(np.array(borders, np.float64)) * field.superpixel
    pieces: list[PictureCounts] = []
    while True:
        number = len(pieces)
        seconds = min(_PIECE_S, longest_s)
        recording = field.record(
            bench, f"detector-ladder-{number}", show, seconds=seconds, pattern_rate_hz=LADDER_HZ, each=_EACH
        )
        pieces.append(counts_of(recording, _EACH))
        _refuse_copies(pieces)
        counts = _folded(together(pieces))
        rungs = [*range(len(names)), len(half) - 1]
        board = [len(names), len(names) + 1]
        ladder = LightLadder(
            lit=lit,
            rate_hz=counts.rate_hz[rungs],
            sigma_hz=counts.sigma_hz[rungs],
            width_mirrors=width_mirrors,
            checker_hz=counts.rate_hz[board],
            checker_sigma_hz=counts.sigma_hz[board],
            checker_sides=4 / field.superpixel,
        )
        fit, between = better(ladder)
        if between >= CERTAIN or (number + 1.5) * seconds > longest_s:
            return fit, between, float(ladder.rate_hz[lit.all(axis=1)].mean())


def _refuse_copies(pieces: list[PictureCounts]) -> None:
    """Refuse a run that counted to the bit what the one before did: only a simulated bench does so.

    Raises:
        InputError: adding it up would tell nothing.
    """
    if len(pieces) > 1 and np.array_equal(pieces[-1].mean, pieces[-2].mean):
        raise InputError(
            device="counter",
            saw="two runs with the same counts to the bit",
            expected="noise of its own in each run",
            remedy="set fresh_noise = true in [scene]",
        )


def _folded(counts: PictureCounts) -> PictureCounts:
    """Add up the two halves of a cycle, there and back."""
    half = len(counts.mean) // 2
    first = PictureCounts(counts.mean[:half], counts.number[:half], counts.picture_time_s)
    second = PictureCounts(counts.mean[half:][::-1], counts.number[half:][::-1], counts.picture_time_s)
    return together([first, second])


def _doubts(fit: DeadTimeFit, between: float, brightest_hz: float) -> list[str]:
    doubts: list[str] = []
    loss = brightest_hz * fit.dead_time_s
    if fit.dead_time_s < _SURE * fit.sigma_s:
        doubts.append(f"no dead time is seen at {brightest_hz:.3g} counts/s: brighter light shows it")
    elif between < CERTAIN:
        doubts.append(
            f"both kinds of dead time fit ({100 * loss:.1f} % are lost): count for longer (--longest), or in brighter light"
        )
    if fit.degrees_of_freedom > 0 and fit.chi_square > 3 * fit.degrees_of_freedom:
        doubts.append(
            f"the ladder scatters {(fit.chi_square / fit.degrees_of_freedom) ** 0.5:.1f} times as much as its counts: "
            "the light is unsteady, or does not add up"
        )
    return doubts
