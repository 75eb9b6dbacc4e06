"""Parts of one computation on several cores, each part by one thread, so that its sums are made in one order."""

from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from functools import cache
from typing import TypeVar

import numba

_T = TypeVar("_T")


def side_by_side(parts: Sequence[Callable[[], _T]]) -> list[_T]:
    """Call functions that hold no lock of Python for long, on as many cores as numba may use; one after the other on one.

    Args:
        parts: functions that do not hang on each other.

    Returns:
        Their results, in order. They are the same on any number of cores.
    """
    threads = numba.get_num_threads()
    if threads == 1 or len(parts) < 2:
        return [part() for part in parts]
    return [future.result() for future in [_pool(threads).submit(part) for part in parts]]


@cache
def _pool(threads: int) -> ThreadPoolExecutor:
    return ThreadPoolExecutor(threads, thread_name_prefix="kinopix-products")
