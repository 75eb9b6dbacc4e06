"""A sweep over points on several processes, which gives the same as one process, and goes on where it was ended.

A point that is finished is on the disk before the next begins, whoever is killed meanwhile. Each point is computed with one
thread of BLAS and of numba, in whatever process, so that sums are always made in the same order.
"""

import os
import signal
from collections.abc import Callable, Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from dataclasses import dataclass, field
from multiprocessing import active_children, get_context, parent_process
from pathlib import Path
from threading import Thread
from typing import Final, Protocol, TypeAlias

import numba

from instrument.numerics import one_blas_thread
from instrument.studies.processing import Outcome
from instrument.studies.store import Point, PointStore

_QUEUED: Final = 1
"""Points that a pool hands out beyond those that its processes work on."""

OnPoint: TypeAlias = Callable[[Point, int, int], None]
"""Function that is called with a point that is finished, or failed, the number of those, and the number of all."""


class _Note(Protocol):
    """Takes a point, by its number, as finished or failed."""

    def __call__(self, k: int, error: str | None = None) -> None: ...


@dataclass
class Sweep:
    """What a sweep gave."""

    outcomes: list[dict[str, Outcome] | None]
    """Outcomes of each point, in the order of the points; None where it failed."""

    failures: dict[str, str] = field(default_factory=dict[str, str])
    """Name of each point that failed, and why."""

    kept: int = 0
    """Number of points that an earlier sweep had finished."""


def sweep(points: Sequence[Point], folder: Path, *, workers: int, on_point: OnPoint | None = None) -> Sweep:
    """Compute all points that are not finished yet.

    Args:
        points: what to compute. Their functions and settings must be known by name in another process.
        folder: of finished points.
        workers: number of processes; 1 computes in this one.
        on_point: function that is called after each point, with those that were finished before first.

    Raises:
        KeyboardInterrupt: all processes are gone, and what is finished is kept.
    """
    store = PointStore(folder)
    done = Sweep([store.read(point) for point in points])
    waiting = [k for k, outcome in enumerate(done.outcomes) if outcome is None]
    done.kept = len(points) - len(waiting)
    finished = 0

    def note(k: int, error: str | None = None) -> None:
        nonlocal finished
        finished += 1
        if error is None and done.outcomes[k] is None:
            done.outcomes[k] = store.read(points[k])
        if error is not None:
            done.failures[points[k].name] = error
        if on_point is not None:
            on_point(points[k], finished, len(points))

    for k, outcome in enumerate(done.outcomes):
        if outcome is not None:
            note(k)
    if workers == 1:
        for k in waiting:
            note(k, _finish(points[k], folder))
        return done
    while waiting:
        left = _in_a_pool(points, waiting, folder, min(workers, len(waiting)), note)
        suspects, waiting = left[: workers + _QUEUED], left[workers + _QUEUED :]
        for k in suspects:  # one of these ended its process: each is computed by itself
            if _in_a_pool(points, [k], folder, 1, note):
                note(k, "its process ended while it was computed; is there memory enough?")
    return done


def _in_a_pool(points: Sequence[Point], waiting: Sequence[int], folder: Path, workers: int, note: _Note) -> list[int]:
    """Compute points in processes of their own; give those that are left because a process ended, in order."""
    left = list(waiting)
    with _pool(workers) as pool:
        with _interrupts_held_back():  # processes that are made meanwhile never hear of Ctrl-C: this one ends them
            futures = {pool.submit(_finish, points[k], folder): k for k in waiting}
        while futures:
            for future in wait(futures, return_when=FIRST_COMPLETED).done:
                k = futures.pop(future)
                try:
                    error = future.result()
                except BrokenProcessPool:
                    continue
                except Exception as refused:  # noqa: BLE001 - what cannot be sent to another process; the rest goes on
                    error = _in_words(refused)
                left.remove(k)
                note(k, error)
    return left


def _finish(point: Point, folder: Path) -> str | None:
    """Compute a point and keep its outcome; give what went wrong, if anything did."""
    threads = numba.get_num_threads()
    numba.set_num_threads(1)
    try:
        with one_blas_thread():
            outcomes = point.compute(point.settings, point.seed)
        PointStore(folder).write(point, outcomes)
    except Exception as error:  # noqa: BLE001 - a point that fails is named, and the rest goes on
        return _in_words(error)
    finally:
        numba.set_num_threads(threads)
    return None


def _in_words(error: Exception) -> str:
    return f"{type(error).__name__}: {error}"


@contextmanager
def _pool(workers: int) -> Generator[ProcessPoolExecutor]:
    """Give fresh processes, of which none is left at the end, however that comes."""
    before = set(active_children())
    pool = ProcessPoolExecutor(workers, mp_context=get_context("spawn"), initializer=_begin)
    try:
        yield pool
    except BaseException:
        for child in set(active_children()) - before:
            child.kill()  # what it writes is whole or not there
        raise
    finally:
        pool.shutdown(wait=True, cancel_futures=True)


@contextmanager
def _interrupts_held_back() -> Generator[None]:
    """Hold back Ctrl-C, for this thread and for processes that it makes, which keep it so."""
    if not hasattr(signal, "pthread_sigmask"):  # Windows
        yield
        return
    before = signal.pthread_sigmask(signal.SIG_BLOCK, {signal.SIGINT})
    try:
        yield
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _begin() -> None:
    """Begin a process of the pool: it leaves Ctrl-C to the one that made it, and ends with that one, however that ends."""
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    Thread(target=_end_with_parent, daemon=True).start()


def _end_with_parent() -> None:
    parent = parent_process()
    if parent is not None:
        parent.join()
        os._exit(1)
