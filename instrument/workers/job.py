"""A job that any process can do, what comes of it, and how it is done: by one thread, so that sums are made in one order."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Protocol, Self

import numba

from instrument.numerics import one_blas_thread
from instrument.storage import program
from protocols import KinopixError


@dataclass(frozen=True)
class Job:
    """A function and its arguments. Another process is told of the function by its name, so that it must stand in a module."""

    name: str
    """Text that names it to people."""

    function: Callable[..., Any]
    """What is called."""

    arguments: tuple[Any, ...] = ()
    """What it is called with."""


@dataclass(frozen=True)
class Failure:
    """Why a job has no result."""

    why: str
    """In words."""

    exit_code: int = 3
    """What a command returns for it: 2 for a wrong input, 3 for everything else."""

    @classmethod
    def of(cls, error: Exception) -> Self:
        """Put an error in words: ours say what was seen, others need their kind beside it."""
        if isinstance(error, KinopixError):
            return cls(str(error), error.exit_code)
        return cls(f"{type(error).__name__}: {error}")


ENDED = Failure("its process ended while it was computed; is there memory enough?")
"""A job whose process was killed, or died."""


class OnJob(Protocol):
    """Takes a job, by its number, with its result, or as one that failed."""

    def __call__(self, number: int, result: Any, failure: Failure | None) -> None:
        """Take it; called in the process that asked for the jobs, one at a time."""
        ...


def done(job: Job) -> tuple[Any, Failure | None]:
    """Do a job with one thread of BLAS and of numba, in whatever process; give its result, or why it has none."""
    threads = numba.get_num_threads()
    numba.set_num_threads(1)
    try:
        with one_blas_thread():
            return job.function(*job.arguments), None
    except Exception as error:  # noqa: BLE001 - a job that fails is named, and the rest goes on
        return None, Failure.of(error)
    finally:
        numba.set_num_threads(threads)


def done_by_the_same(job: Job, asked_by: str) -> tuple[Any, Failure | None]:
    """Do a job, as ``done``, if the program here is the one that asks.

    Args:
        job: what to do.
        asked_by: version and digest of the program that asks.
    """
    if program() != asked_by:
        return None, Failure(
            f"the worker has another program ({_short(program())}) than the one that asks ({_short(asked_by)}): "
            "install the same version of Kinopix and its libraries on both computers; on this one its files were changed "
            "meanwhile, so begin again",
            exit_code=2,
        )
    return done(job)


def _short(of_program: str) -> str:
    """Give the versions whole, and the beginning of the digest."""
    versions, digest = of_program.rsplit(" ", 1)
    return f"{versions} {digest[:8]}"
