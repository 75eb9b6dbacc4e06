"""One BLAS thread for many small products.

What is left of matrix products in the analysis is small: some 1,666 x 128. A second BLAS thread wins little there on a free
machine, and on a busy one the two wait for each other in busy loops: measured at a load of 6 on 2 cores, one such product took
3 ms with one thread and 16 ms with two.
"""

from collections.abc import Generator
from contextlib import contextmanager
from functools import cache
from threading import Lock
from typing import Any

from threadpoolctl import ThreadpoolController


class BlasLimit:
    """One BLAS thread in the whole process, from the first who wants it until the last has enough."""

    def __init__(self) -> None:
        """Prepare; nothing is limited yet."""
        self._lock = Lock()
        self._holders = 0
        self._limiter: Any = None  # threadpoolctl has no types

    @contextmanager
    def held(self) -> Generator[None, None, None]:
        """Hold the limit inside the block. Blocks may overlap, in one thread or in several."""
        with self._lock:
            if self._holders == 0:
                self._limiter = _controller().limit(limits=1, user_api="blas")
            self._holders += 1
        try:
            yield
        finally:
            with self._lock:
                self._holders -= 1
                if self._holders == 0:
                    self._limiter.restore_original_limits()


@cache
def _controller() -> Any:
    return ThreadpoolController()


_whole_process = BlasLimit()


@contextmanager
def one_blas_thread() -> Generator[None, None, None]:
    """Let BLAS use one thread inside the block, or inside the function that is decorated with it; in the whole process.

    Blocks may overlap, in one thread or in several: the limit is lifted when the last of them ends.
    """
    with _whole_process.held():
        yield
