"""One BLAS thread for many small products.

What is left of matrix products in the analysis is small: some 1,666 x 128. A second BLAS thread wins little there on a free
machine, and on a busy one the two wait for each other in busy loops: measured at a load of 6 on 2 cores, one such product took
3 ms with one thread and 16 ms with two.
"""

from collections.abc import Generator
from contextlib import contextmanager
from functools import cache
from typing import Any

from threadpoolctl import ThreadpoolController


@cache
def _blas() -> Any:  # threadpoolctl has no types
    return ThreadpoolController()


@contextmanager
def one_blas_thread() -> Generator[None, None, None]:
    """Let BLAS use one thread inside the block, or inside the function that is decorated with it; in the whole process."""
    with _blas().limit(limits=1, user_api="blas"):
        yield
