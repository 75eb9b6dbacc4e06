"""A sweep over points, which gives the same wherever they are computed, and goes on where it was ended.

A point that is finished is on the disk before the next is taken, whoever is killed meanwhile.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, TypeAlias

from instrument.studies.processing import Outcome
from instrument.studies.store import Point, PointStore
from instrument.workers import Failure, Job, Where, carry_out

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
        KinopixError: as ``carry_out``, where there is no such scheduler.
    """
    store = PointStore(folder)
    done = Sweep([store.read(point) for point in points])
    waiting = [k for k, outcome in enumerate(done.outcomes) if outcome is None]
    done.kept = len(points) - len(waiting)
    finished = 0

    def tell(point: Point) -> None:
        nonlocal finished
        finished += 1
        if on_point is not None:
            on_point(point, finished, len(points))

    def keep(number: int, result: Any, failure: Failure | None) -> None:
        k = waiting[number]
        if failure is None:
            try:
                store.write(points[k], result)
            except Exception as error:  # noqa: BLE001 - a point that cannot be kept is named, and the rest goes on
                failure = Failure.of(error)
            else:
                done.outcomes[k] = result
        if failure is not None:
            done.failures[points[k].name] = failure.why
        tell(points[k])

    for point, outcome in zip(points, done.outcomes, strict=True):
        if outcome is not None:
            tell(point)
    jobs = [Job(points[k].name, points[k].compute, (points[k].settings, points[k].seed)) for k in waiting]
    carry_out(jobs, Where(workers, scheduler), keep)
    return done
