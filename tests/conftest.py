"""What every test session needs."""

import gc
from collections.abc import Generator

import pytest
from hypothesis import settings

from instrument.numerics.blas import one_blas_thread

settings.register_profile("kinopix", deadline=None)  # a first call imports and compiles, and the machine may be busy
settings.load_profile("kinopix")


def pytest_collection() -> None:
    """Look for no garbage while all tests are imported: there is hardly any."""
    gc.disable()


def pytest_collection_finish() -> None:
    """Nor ever look through what is there for good: libraries and tests, a million objects."""
    gc.freeze()
    gc.set_threshold(5_000, 20, 10)
    gc.enable()


@pytest.fixture(scope="session", autouse=True)
def one_blas_thread_for_all() -> Generator[None, None, None]:
    """Sessions run side by side: two BLAS threads each would wait for each other."""
    with one_blas_thread():
        yield
