"""A sweep over points, which gives the same wherever they are computed, and goes on where it was ended.

A point that is finished is on the disk before the next is taken, whoever is killed meanwhile.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import TypeAlias

from instrument.studies.processing import Outcome
from instrument.studies.store import Point, PointStore
from instrument.workers import Job, Where, do_missing

OnPoint: TypeAlias = Callable[[Point, int, int], None]
"""Function that is called with a point that is finished, or failed, the number of those, and the number of all."""


@dataclass
class Sweep:
    """What a sweep gave."""

    outcomes: list[dict[str, Outcome] | None]
    """Outcomes of each point, in the order of the points; None where it failed."""

    failures: dict[str, str] = field(default_factory=dict[str, str])
    """Name of each point that failed, and why."""

    kept: int = 0
    """Number of points that an earlier sweep had finished."""


def sweep(
    points: Sequence[Point],
    folder: Path,
    *,
    workers: int = 1,
    scheduler: str | None = None,
    on_point: OnPoint | None = None,
) -> Sweep:
    """Compute all points that are not finished yet.

    Args:
        points: what to compute. Their functions and settings must be known by name in another process.
        folder: of finished points.
        workers: number of processes; 1 computes in this one.
        scheduler: address of a Dask scheduler whose workers compute instead; None for this computer.
        on_point: function that is called after each point, with those that were finished before first.

    Raises:
        KeyboardInterrupt: all processes are gone, and what is finished is kept.
        KinopixError: as ``do_missing``, where there is no such scheduler.
    """
    store = PointStore(folder)

    def keep(number: int, outcome: dict[str, Outcome]) -> dict[str, Outcome]:
        store.write(points[number], outcome)
        return outcome

    done = do_missing(
        range(len(points)),
        known=lambda number: store.read(points[number]),
        job=lambda number: Job(
            points[number].name, points[number].compute, (points[number].settings, points[number].seed)
        ),
        keep=keep,
        where=Where(workers, scheduler),
        on_each=None if on_point is None else lambda number, done, total: on_point(points[number], done, total),
    )
    failures = {points[number].name: failure.why for number, failure in done.failures.items()}
    return Sweep([done.found.get(number) for number in range(len(points))], failures, len(done.kept))
