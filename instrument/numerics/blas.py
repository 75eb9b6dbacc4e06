"""A limit of one BLAS thread, for many small products.

The matrix products of the analysis are small, such as 1,666 x 128. A second BLAS thread gains little there on an idle machine; on
a loaded one the two threads wait for each other in busy loops, and a product takes several times as long
(``docs/decisions/0009-compiled-loops.md``).
"""

from collections.abc import Generator
from contextlib import contextmanager
from functools import cache
from importlib import import_module
from threading import Lock
from typing import Any

from threadpoolctl import ThreadpoolController


class BlasLimit:
    """Limits BLAS to one thread in the whole process, from the first block that holds the limit to the end of the last."""

    def __init__(self) -> None:
        """Prepare without limiting anything yet."""
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
    """Find the BLAS libraries of the process, once. SciPy brings one of its own, which must be loaded to be found."""
    import_module("scipy.linalg")
    return ThreadpoolController()


_whole_process = BlasLimit()


@contextmanager
def one_blas_thread() -> Generator[None, None, None]:
    """Let BLAS use one thread inside the block, or inside the function that is decorated with it; in the whole process.

    Blocks may overlap, in one thread or in several: the limit is lifted when the last of them ends.
    """
    with _whole_process.held():
        yield
