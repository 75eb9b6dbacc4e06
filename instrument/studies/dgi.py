"""The supplement of the paper on differential ghost imaging: an image without a solver."""

from typing import Final

from instrument.studies.processing import Outcome, as_published, own
from instrument.studies.simulated import Simulated, record
from instrument.studies.study import Axis, Case, Claim, Study, Summary, paragraph

_PARTS: Final = (0.2, 0.6, 1.0)
_GHOST: Final = "DGI, as published"
_SOLVED: Final = "TVAL3, as published"
_OWN_GHOST: Final = "DGI on Kinopix's path"
_OWN: Final = "Kinopix"


def compute(settings: Simulated, seed: int) -> dict[str, Outcome]:
    """Process one run in four ways."""
    recording = record(settings, seed)
    return {
        _GHOST: as_published(recording, ghost=True),
        _SOLVED: as_published(recording),
        _OWN_GHOST: own(recording, "dgi"),
        _OWN: own(recording),
    }


def claims(summary: Summary) -> list[Claim]:
    """The solver beats the ghost image, at every number of frames."""
    labels = [case.label for case in summary.study.cases]
    pairs = [[summary.mean(label, of, "psnr_db") for of in (_GHOST, _SOLVED)] for label in labels]
    text = ", ".join(f"{ghost:.1f} to {solved:.1f}" for ghost, solved in pairs)
    return [Claim(f"TVAL3's image is better than DGI's: {text} dB", all(ghost < solved for ghost, solved in pairs))]


STUDY: Final = Study(
    name="dgi",
    title="Supplement: differential ghost imaging",
    about=paragraph(
        """
        Motion II of table 1, ended after 20, 60 and 100 % of the frames. The ghost image (Ferri et al., Phys. Rev.
        Lett. 104, 253603) is one sum over the shifted patterns, with the gain that explains the values best.
        """
    ),
    cases=tuple(Case(f"{round(100 * part)} %", Simulated(part=part), "motion II", 100 * part) for part in _PARTS),
    processings=(_GHOST, _SOLVED, _OWN_GHOST, _OWN),
    compute=compute,
    claims=claims,
    differences=paragraph(
        """
        We have no figures of the supplement.
        """
    ),
    axis=Axis("frames used, %"),
)
"""The study."""
