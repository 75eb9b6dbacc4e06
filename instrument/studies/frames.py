"""Figures 4 and 7 of the paper: displacement and image from the first 10 % to 100 % of the frames."""

from typing import Final

from instrument.studies.experiment import EXPERIMENT
from instrument.studies.processing import Outcome, as_published, own
from instrument.studies.simulated import Simulated, record
from instrument.studies.study import Axis, Case, Claim, Study, Summary, paragraph
from instrument.studies.table1 import KINOPIX, PUBLISHED

_PARTS: Final = tuple(k / 10 for k in range(1, 11))

_CURVES: Final = {
    "fig. 4, I": Simulated(motion="I"),
    "fig. 4, II": Simulated(motion="II"),
    "fig. 7, 25 mm/s": EXPERIMENT.model_copy(update={"motion": "uniform"}),
    "fig. 7, 25 mm/s + 50 mm/s²": EXPERIMENT.model_copy(update={"motion": "accelerated"}),
}


def compute(settings: Simulated, seed: int) -> dict[str, Outcome]:
    """Process one run in both ways, with the five-point filter where photons are counted, as in the experiment."""
    recording = record(settings, seed)
    mean_filter = 1 if settings.peak_counts is None else 5
    return {PUBLISHED: as_published(recording, mean_filter=mean_filter), KINOPIX: own(recording)}


def claims(summary: Summary) -> list[Claim]:
    """A fast rise, then flat: half of the frames bring most of what all of them bring."""
    found: list[Claim] = []
    for curve in _CURVES:
        for processing in (PUBLISHED, KINOPIX):
            first, half, whole = (summary.mean(f"{curve}, {part} %", processing, "psnr_db") for part in (10, 50, 100))
            text = f"{curve}, {processing}: fast rise, then flat: {first:.1f}, {half:.1f}, {whole:.1f} dB"
            text += " from 10, 50, 100 % of the frames"
            found.append(Claim(text, half - first > 2 * abs(whole - half)))
    return found


STUDY: Final = Study(
    name="frames",
    title="Figures 4 and 7: how many frames it takes",
    about=paragraph(
        """
        The runs of table 1 (fig. 4) and runs at the experiment's speeds with photons counted (fig. 7), ended after 10 %
        to 100 % of their frames. Fig. 7 here: a "B" 23 px high along the diagonal at 7.2 px/mm, 250 counts of an
        all-lit pattern, an ideal bench.
        """
    ),
    cases=tuple(
        Case(f"{curve}, {round(100 * part)} %", settings.model_copy(update={"part": part}), curve, 100 * part)
        for curve, settings in _CURVES.items()
        for part in _PARTS
    ),
    processings=(PUBLISHED, KINOPIX),
    compute=compute,
    claims=claims,
    differences=paragraph(
        """
        The paper shows images and curves here and prints no figures. Its fig. 7 is measured, with an image of 19,992
        patterns at rest as the reference; ours is simulated, so that the truth itself is the reference.
        """
    ),
    axis=Axis("frames used, %"),
)
"""The study."""
