"""Tables and figures of the paper, reproduced: what is simulated, processed and compared, and the sweeps that do it."""

from typing import Final

from instrument.studies import background, dgi, frames, noise, speed, table1, upsampling
from instrument.studies.motions import accelerated, curve
from instrument.studies.processing import MU, Outcome, as_published
from instrument.studies.reproduce import Result, reproduce
from instrument.studies.simulated import Simulated
from instrument.studies.store import Point
from instrument.studies.study import METRICS, Axis, Case, Claim, Metric, Spread, Study, Summary
from instrument.studies.sweep import Sweep, sweep

STUDIES: Final = {
    module.STUDY.name: module.STUDY for module in (table1, frames, noise, upsampling, speed, background, dgi)
}
"""Every study by its name, in the order in which the paper has them."""

__all__ = [
    "METRICS",
    "MU",
    "STUDIES",
    "Axis",
    "Case",
    "Claim",
    "Metric",
    "Outcome",
    "Point",
    "Result",
    "Simulated",
    "Spread",
    "Study",
    "Summary",
    "Sweep",
    "accelerated",
    "as_published",
    "curve",
    "reproduce",
    "sweep",
]
