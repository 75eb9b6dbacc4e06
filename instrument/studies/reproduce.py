"""Studies carried out: their points computed, and summed up."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

from instrument.studies.processing import Outcome
from instrument.studies.store import Point
from instrument.studies.study import Study, Summary
from instrument.studies.sweep import OnPoint, sweep
from protocols import Floats


@dataclass(frozen=True, eq=False)
class Result:
    """A study that was carried out."""

    study: Study
    """The study."""

    seeds: int
    """Number of seeds: 0, 1, 2, ..."""

    outcomes: Mapping[tuple[str, int], Mapping[str, Outcome]]
    """Outcome of each processing, by case and seed; points that failed are missing."""

    failures: Mapping[str, str] = field(default_factory=dict[str, str])
    """Why, by name of the point."""

    @property
    def summary(self) -> Summary:
        """The figures over all seeds."""
        return Summary.of(self.study, self.outcomes)

    def image(self, label: str, processing: str) -> Floats | None:
        """``(m, m)``: the image of the first seed that has one."""
        for (case, _seed), of_point in sorted(self.outcomes.items()):
            if case == label and processing in of_point:
                return of_point[processing].image
        return None


def points_of(study: Study, seeds: int) -> list[Point]:
    """List what is computed for a study."""
    return [
        Point(f"{study.name}: {case.label}, seed {seed}", case.label, study.compute, case.settings, seed)
        for case in study.cases
        for seed in range(seeds)
    ]


def reproduce(
    studies: Sequence[Study],
    folder: Path,
    *,
    seeds: int | None = None,
    workers: int = 1,
    scheduler: str | None = None,
    on_point: OnPoint | None = None,
) -> list[Result]:
    """Carry out studies: all their points in one sweep, those that are finished already left out.

    Args:
        studies: what to carry out.
        folder: of finished points.
        seeds: number of seeds; None takes each study's own.
        workers: number of processes.
        scheduler: address of a Dask scheduler, as for ``sweep``.
        on_point: function that is called after each point.
    """
    counts = [study.seeds if seeds is None else seeds for study in studies]
    points = [points_of(study, count) for study, count in zip(studies, counts, strict=True)]
    every = [point for of_study in points for point in of_study]
    done = sweep(every, folder, workers=workers, scheduler=scheduler, on_point=on_point)
    results: list[Result] = []
    outcomes = iter(done.outcomes)
    for study, count, of_study in zip(studies, counts, points, strict=True):
        found = {(point.label, point.seed): next(outcomes) for point in of_study}
        failed = {point.name: done.failures[point.name] for point in of_study if point.name in done.failures}
        good = {key: outcome for key, outcome in found.items() if outcome is not None}
        results.append(Result(study, count, good, failed))
    return results
