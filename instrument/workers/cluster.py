"""Jobs on a Dask cluster, which somebody else has started: ``dask scheduler``, and ``dask worker`` on each computer.

Every worker must have the same program as this computer, to the byte: results would not be the same otherwise. Each job carries
the program's digest, and a worker with another one refuses it.
"""

from collections.abc import Sequence
from types import ModuleType
from typing import Any, Final

from instrument.storage import program
from instrument.workers.job import ENDED, Failure, Job, OnJob, done_by_the_same
from protocols import InputError, KinopixError

_ANSWER_S: Final = 5
"""Time within which a scheduler must answer."""

_WORKER_S: Final = 30
"""Time within which its first worker must be there: one that has just been started loads its libraries."""


def on_cluster(jobs: Sequence[Job], address: str, on_job: OnJob) -> None:
    """Do jobs on the workers of a Dask scheduler.

    Args:
        jobs: what to do.
        address: of the scheduler, such as ``tcp://10.0.0.5:8786``.
        on_job: as for ``carry_out``.

    Raises:
        InputError: no such address, or Dask is not installed.
        KinopixError: no scheduler answers there, or it has no workers.
    """
    dask = _dask()
    with _connected(dask, address) as client:
        futures = {
            client.submit(done_by_the_same, job, program(), key=f"kinopix-{number}-{client.id}", pure=False): number
            for number, job in enumerate(jobs)
        }
        try:
            for future in dask.as_completed(list(futures), loop=client.loop):
                on_job(futures[future], *_answer(dask, future))
                future.release()
        except BaseException:
            client.cancel(list(futures))
            raise


def _answer(dask: ModuleType, future: Any) -> tuple[Any, Failure | None]:
    try:
        result, failure = future.result()
    except dask.KilledWorker:
        return None, ENDED
    except dask.CancelledError as error:
        return None, Failure(f"the scheduler went away, or somebody took the job from it ({error})")
    except Exception as error:  # noqa: BLE001 - what cannot be sent to another process; the rest goes on
        return None, Failure.of(error)
    else:
        return result, failure


def _dask() -> ModuleType:
    try:
        import distributed  # noqa: PLC0415 - an extra, and a second to load
    except ImportError as error:
        raise InputError(
            saw=f"--scheduler without Dask ({error})",
            expected="the library distributed",
            remedy="install kinopix[cluster], or leave --scheduler out for processes of this computer",
        ) from error
    return distributed


def _connected(dask: ModuleType, address: str) -> Any:
    """Give a client of the scheduler, to be closed."""
    try:
        client = dask.Client(address, timeout=_ANSWER_S, set_as_default=False)
    except ValueError as error:
        raise InputError(
            saw=f"the scheduler {address!r} ({error})",
            expected="an address such as tcp://10.0.0.5:8786",
            remedy="give the address that `dask scheduler` prints when it begins",
        ) from error
    except (OSError, TimeoutError) as error:
        raise KinopixError(
            saw=f"no answer from a scheduler at {address} within {_ANSWER_S} s",
            expected="a Dask scheduler of the version that is installed here",
            remedy="start `dask scheduler`, and give the address that it prints",
        ) from error
    try:
        client.wait_for_workers(1, timeout=_WORKER_S)
    except TimeoutError as error:
        client.close()
        raise KinopixError(
            saw=f"a scheduler at {address} without workers",
            expected="one or more, with Kinopix installed",
            remedy=f"start `dask worker {address}` on each computer that is to help",
        ) from error
    return client
