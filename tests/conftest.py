"""What every test session needs."""

from collections.abc import Generator

import pytest

from instrument.numerics.blas import one_blas_thread


@pytest.fixture(scope="session", autouse=True)
def one_blas_thread_for_all() -> Generator[None, None, None]:
    """Sessions run side by side: two BLAS threads each would wait for each other."""
    with one_blas_thread():
        yield
