"""What a study is: runs that are simulated, processed and compared with what the paper prints."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Final, TypeAlias

from instrument.choices import StudyName
from instrument.studies.processing import Outcome
from instrument.studies.simulated import Simulated

Compute: TypeAlias = Callable[[Simulated, int], dict[str, Outcome]]
"""What one point computes: settings and seed to the outcome of each processing. A function of a module, so that another
process can be told of it by name, and a pure one."""


def paragraph(text: str) -> str:
    """Give a text that is written over several lines as one."""
    return " ".join(text.split())


@dataclass(frozen=True)
class Metric:
    """A figure of merit, as people read it."""

    title: str
    """Name with its unit."""

    digits: int
    """Digits behind the point."""

    logarithmic: bool = False
    """Whether it is drawn on a logarithmic axis."""


METRICS: Final[dict[str, Metric]] = {
    "mse_px2": Metric("displacement MSE, px²", 3, logarithmic=True),
    "psnr_db": Metric("PSNR, dB", 2),
    "ssim_global": Metric("SSIM, global formula", 3),
    "ssim_local": Metric("SSIM, local formula", 3),
}
"""Every figure of merit by its name in ``Outcome.figures``."""


@dataclass(frozen=True)
class Case:
    """One row of a study's tables: a run that is repeated with other noise."""

    label: str
    """Text of the row, its own in the study."""

    settings: Simulated
    """The run."""

    curve: str = ""
    """Curve of the figure to which it belongs."""

    x: float | None = None
    """Its place along the figure's axis; None where the study has none."""


@dataclass(frozen=True)
class Axis:
    """The horizontal axis of a study's figure."""

    title: str
    """Name with its unit."""

    logarithmic: bool = False
    """Whether its steps are ratios."""


@dataclass(frozen=True)
class Spread:
    """A figure over all seeds."""

    mean: float
    """Mean."""

    deviation: float
    """Standard deviation of a single seed's figure; 0 for a single seed."""

    count: int
    """Number of seeds."""

    @classmethod
    def of(cls, values: list[float]) -> "Spread":
        """Give mean and standard deviation (n - 1)."""
        mean = math.fsum(values) / len(values)
        square = math.fsum((value - mean) ** 2 for value in values)
        return cls(mean, math.sqrt(square / (len(values) - 1)) if len(values) > 1 else 0.0, len(values))


@dataclass(frozen=True)
class Summary:
    """The figures of a study over all seeds."""

    study: "Study"
    """The study."""

    spreads: Mapping[tuple[str, str, str], Spread]
    """By case, processing and figure of merit."""

    @classmethod
    def of(cls, study: "Study", outcomes: Mapping[tuple[str, int], Mapping[str, Outcome]]) -> "Summary":
        """Sum up the outcomes, given by case and seed; points that failed are left out."""
        values: dict[tuple[str, str, str], list[float]] = {}
        for (label, _seed), of_point in sorted(outcomes.items()):
            for processing, outcome in of_point.items():
                for metric, value in outcome.figures.items():
                    values.setdefault((label, processing, metric), []).append(value)
        return cls(study, {key: Spread.of(of_key) for key, of_key in values.items()})

    def mean(self, label: str, processing: str, metric: str) -> float:
        """Give a mean; NaN where no seed has it."""
        spread = self.spreads.get((label, processing, metric))
        return math.nan if spread is None else spread.mean

    @property
    def metrics(self) -> list[str]:
        """Figures of merit that any case has, in the order of ``METRICS``."""
        return [name for name in METRICS if any(key[2] == name for key in self.spreads)]


@dataclass(frozen=True)
class Claim:
    """A sentence of the paper, or a bar, and whether our figures hold it."""

    text: str
    """The sentence, with our figures."""

    holds: bool
    """Whether it is so here."""


@dataclass(frozen=True)
class Study:
    """One table or figure of the paper."""

    name: StudyName
    """Name on the command line."""

    title: str
    """Heading."""

    about: str
    """What is simulated and compared, in a paragraph."""

    cases: tuple[Case, ...]
    """Rows, in order."""

    processings: tuple[str, ...]
    """Columns, in order, each the name of a processing in what ``compute`` gives."""

    compute: Compute
    """What one point computes."""

    claims: Callable[[Summary], list[Claim]]
    """What the paper says, held against our figures."""

    differences: str
    """Where we differ from the paper, and why."""

    axis: Axis | None = None
    """Axis of the figure; None for a table, whose figure has a line for each row."""

    paper: Mapping[tuple[str, str], float] = field(default_factory=dict[tuple[str, str], float])
    """Figures that the paper prints, by case and figure of merit."""

    seeds: int = 3
    """Number of seeds unless somebody wants another: 0, 1, 2, ..."""
