"""What every test session needs."""

import gc
from collections.abc import Generator

import pytest
from hypothesis import settings

from instrument.numerics.blas import one_blas_thread

settings.register_profile("kinopix", deadline=None)  # a first call imports and compiles, and the machine may be busy
settings.load_profile("kinopix")


@pytest.hookimpl(wrapper=True)
def pytest_collection() -> Generator[None, object, object]:
    """Look for no garbage while all tests are imported, nor ever through what is then there for good: a million objects."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.set_threshold(5_000, 20, 10)
        gc.enable()


@pytest.fixture(scope="session", autouse=True)
def one_blas_thread_for_all() -> Generator[None, None, None]:
    """Sessions run side by side: two BLAS threads each would wait for each other."""
    with one_blas_thread():
        yield
