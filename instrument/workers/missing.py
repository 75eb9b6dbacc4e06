"""What is not done yet, carried out: a series goes on where it was ended, and nothing in it is done twice."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any, Generic, TypeVar

from instrument.workers.carry_out import Where, carry_out
from instrument.workers.job import Failure, Job

_Of = TypeVar("_Of")
_Result = TypeVar("_Result")


@dataclass
class Progress(Generic[_Of, _Result]):
    """What became of a series: each of it is in ``found`` or in ``failures``."""

    found: dict[_Of, _Result]
    """Results."""

    kept: frozenset[_Of]
    """Those whose result had been found before."""

    failures: dict[_Of, Failure] = field(default_factory=dict[_Of, Failure])
    """The others, and why."""


def do_missing(
    every: Sequence[_Of],
    *,
    known: Callable[[_Of], _Result | None],
    job: Callable[[_Of], Job],
    keep: Callable[[_Of, Any], _Result],
    where: Where,
    on_each: Callable[[_Of, int, int], None] | None = None,
) -> Progress[_Of, _Result]:
    """Carry out the jobs of a series that have no result yet. One that fails is named, and the others go on.

    Args:
        every: what the series is of, each once.
        known: gives the result that was found before; None where there is none.
        job: gives what is to be done for it.
        keep: keeps what a job gave, before the next is taken, and gives the result. What it raises makes the job one that failed.
        where: who does the work.
        on_each: function that is called with each that is done, or failed, the number of those, and the number of all; with
            those that had been done before first.

    Raises:
        InputError, KinopixError, KeyboardInterrupt: as ``carry_out``; what is kept stays.
    """
    before = {each: result for each in every if (result := known(each)) is not None}
    progress = Progress(before, frozenset(before))
    waiting = [each for each in every if each not in before]
    told = 0

    def tell(each: _Of) -> None:
        nonlocal told
        told += 1
        if on_each is not None:
            on_each(each, told, len(every))

    def take(number: int, result: Any, failure: Failure | None) -> None:
        each = waiting[number]
        if failure is None:
            try:
                progress.found[each] = keep(each, result)
            except Exception as error:  # noqa: BLE001 - a result that cannot be kept is named, and the rest goes on
                failure = Failure.of(error)
        if failure is not None:
            progress.failures[each] = failure
        tell(each)

    for each in before:
        tell(each)
    carry_out([job(each) for each in waiting], where, take)
    return progress
