"""Where jobs are carried out: in this process, on several of this computer, or on a Dask cluster."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Self

from instrument.workers.cluster import on_cluster
from instrument.workers.job import Job, OnJob, done
from instrument.workers.processes import cores, on_processes


@dataclass(frozen=True)
class Where:
    """Who does the work."""

    processes: int = 1
    """Processes of this computer; 1 computes in this one."""

    scheduler: str | None = None
    """Address of a Dask scheduler, such as ``tcp://10.0.0.5:8786``; None for this computer."""

    @classmethod
    def of(cls, workers: int | None, scheduler: str | None) -> Self:
        """Take what a command was given: without a number of processes, one for each core that this one may use."""
        return cls(workers or cores(), scheduler)


def carry_out(jobs: Sequence[Job], where: Where, on_job: OnJob) -> None:
    """Do all jobs. One that fails is handed over as such, and the others go on.

    Args:
        jobs: what to do.
        where: who does it.
        on_job: function that is called with each job when it is done, in any order. What it keeps is kept before the next job
            is handed over.

    Raises:
        InputError: no address of a scheduler, or Dask is not installed.
        KinopixError: no scheduler answers, or it has no workers.
        KeyboardInterrupt: local processes are gone; a cluster is told to leave what has not begun.
    """
    if where.scheduler is not None:
        on_cluster(jobs, where.scheduler, on_job)
    elif where.processes == 1 or len(jobs) == 1:
        for number, job in enumerate(jobs):
            on_job(number, *done(job))
    else:
        on_processes(jobs, where.processes, on_job)
