"""Jobs on processes of this computer. None of them is left, however this one ends."""

import os
import signal
from collections.abc import Generator, Sequence
from concurrent.futures import FIRST_COMPLETED, ProcessPoolExecutor, wait
from concurrent.futures.process import BrokenProcessPool
from contextlib import contextmanager
from multiprocessing import active_children, get_context, parent_process
from threading import Thread
from typing import Final

from instrument.storage import program
from instrument.workers.job import ENDED, Failure, Job, OnJob, done_by_the_same

_QUEUED: Final = 1
"""Jobs that a pool hands out beyond those that its processes work on."""


def cores() -> int:
    """Give the number of cores that this process may use."""
    if hasattr(os, "sched_getaffinity"):
        return len(os.sched_getaffinity(0))
    return os.cpu_count() or 1


def on_processes(jobs: Sequence[Job], processes: int, on_job: OnJob) -> None:
    """Do jobs in fresh processes. Where one of these ends, the jobs that may have ended it are done one by one.

    A process that finds another program than this one was when it began, as somebody installs a new version meanwhile, refuses.

    Args:
        jobs: what to do.
        processes: at most so many at a time.
        on_job: as for ``carry_out``.
    """
    waiting = list(range(len(jobs)))
    while waiting:
        left = _in_a_pool(jobs, waiting, min(processes, len(waiting)), on_job)
        suspects, waiting = left[: processes + _QUEUED], left[processes + _QUEUED :]
        for number in suspects:  # one of these ended its process: each is done by itself
            if _in_a_pool(jobs, [number], 1, on_job):
                on_job(number, None, ENDED)


def _in_a_pool(jobs: Sequence[Job], waiting: Sequence[int], processes: int, on_job: OnJob) -> list[int]:
    """Do jobs in processes of their own; give those that are left because a process ended, in order."""
    left = list(waiting)
    with _pool(processes) as pool:
        with _interrupts_held_back():  # processes that are made meanwhile never hear of Ctrl-C: this one ends them
            futures = {pool.submit(done_by_the_same, jobs[number], program()): number for number in waiting}
        while futures:
            for future in wait(futures, return_when=FIRST_COMPLETED).done:
                number = futures.pop(future)
                try:
                    result, failure = future.result()
                except BrokenProcessPool:
                    continue
                except Exception as refused:  # noqa: BLE001 - what cannot be sent to another process; the rest goes on
                    result, failure = None, Failure.of(refused)
                left.remove(number)
                on_job(number, result, failure)
    return left


@contextmanager
def _pool(processes: int) -> Generator[ProcessPoolExecutor]:
    """Give fresh processes, of which none is left at the end, however that comes."""
    before = set(active_children())
    pool = ProcessPoolExecutor(processes, mp_context=get_context("spawn"), initializer=_begin)
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
