"""Figures 8 and 9 of the paper: a stationary background, from weak to as bright as the object."""

from dataclasses import replace
from itertools import pairwise
from typing import Final

from instrument.studies.experiment import EXPERIMENT
from instrument.studies.processing import Outcome, as_published, own
from instrument.studies.simulated import Simulated, record
from instrument.studies.study import METRICS, Axis, Case, Claim, Study, Summary, paragraph

_RATIOS: Final = (8.60, 3.25, 1.60, 1.04)
_PLAIN: Final = "as published"
_FILTERED: Final = "as published, five-point filter"
_SUBTRACTED: Final = "Kinopix, background subtracted"
_ALONE: Final = "Kinopix, from the run alone"


def compute(settings: Simulated, seed: int) -> dict[str, Outcome]:
    """Process one run in four ways; the last one is told nothing of the background that was measured."""
    recording = record(settings, seed)
    return {
        _PLAIN: as_published(recording),
        _FILTERED: as_published(recording, mean_filter=5),
        _SUBTRACTED: own(recording),
        _ALONE: own(replace(recording, background=None)),
    }


def claims(summary: Summary) -> list[Claim]:
    """Quality falls with the background, and the filter helps."""
    found = [_falls(summary, processing) for processing in (_PLAIN, _FILTERED)]
    for metric, less in (("mse_px2", True), ("psnr_db", False)):
        pairs = [[summary.mean(f"R = {ratio:.2f}", of, metric) for of in (_PLAIN, _FILTERED)] for ratio in _RATIOS]
        helps = all(filtered < plain if less else filtered > plain for plain, filtered in pairs)
        text = ", ".join(f"{plain:.3g} to {filtered:.3g}" for plain, filtered in pairs)
        found.append(Claim(f"the filter helps at every R: {METRICS[metric].title} {text}", helps))
    return found


def _falls(summary: Summary, processing: str) -> Claim:
    """Whether PSNR falls from the weakest background to the brightest, and rises nowhere by more than its standard error."""
    spreads = [summary.spreads.get((f"R = {ratio:.2f}", processing, "psnr_db")) for ratio in _RATIOS]
    known = [spread for spread in spreads if spread is not None]
    text = f"{processing}: PSNR falls with the background, within its standard error: "
    text += f"{', '.join(f'{spread.mean:.1f}' for spread in known)} dB"
    level = all(after.mean - before.mean <= after.deviation / after.count**0.5 for before, after in pairwise(known))
    return Claim(text, len(known) == len(_RATIOS) and level and known[-1].mean < known[0].mean)


STUDY: Final = Study(
    name="background",
    title="Figures 8 and 9: a stationary background",
    about=paragraph(
        """
        The letters "I" and "T" stand beside the object, R is the object's total light over theirs. The experiment's run
        at 25 mm/s, 250 counts of an all-lit pattern by the object alone, on an ideal bench. As published, the
        background's values are measured once without the object and subtracted.
        """
    ),
    cases=tuple(
        Case(f"R = {ratio:.2f}", EXPERIMENT.model_copy(update={"background_ratio": ratio}), "25 mm/s", 1 / ratio)
        for ratio in _RATIOS
    ),
    processings=(_PLAIN, _FILTERED, _SUBTRACTED, _ALONE),
    compute=compute,
    claims=claims,
    differences=paragraph(
        """
        Figs. 8 and 9 are measured and shown as images and curves, without figures in print. Here only the photons of
        the background, counted twice, make things worse with 1/R: a lamp that drifts between the two runs would do so
        too. The last column is given the run with the object alone. There Kinopix is not equally good at every R: at
        8.60 and 1.04 its path is ten times worse than with the background subtracted, which three seeds do not explain,
        and we do not know why.
        """
    ),
    axis=Axis("1 / R, background over object"),
)
"""The study."""
