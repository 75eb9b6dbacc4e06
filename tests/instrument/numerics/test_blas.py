"""The limit on BLAS threads is there while anybody wants it, and gone afterwards."""

from threading import Event, Thread

import pytest
from threadpoolctl import threadpool_info, threadpool_limits

from instrument.numerics.blas import BlasLimit


def _threads() -> list[int]:
    return [pool["num_threads"] for pool in threadpool_info() if pool["user_api"] == "blas"]


@pytest.fixture(autouse=True)
def _two_threads() -> object:
    """Begin with two threads, whatever the machine has."""
    with threadpool_limits(2, user_api="blas"):
        yield


def test_blocks_of_two_threads_that_overlap_leave_blas_as_it_was() -> None:
    """The first ends while the second goes on: until then one thread, afterwards two."""
    limit, inside, leave = BlasLimit(), Event(), Event()

    def first() -> None:
        with limit.held():
            inside.set()
            leave.wait(10)

    thread = Thread(target=first)
    thread.start()
    assert inside.wait(10)
    with limit.held():
        leave.set()
        thread.join()
        assert set(_threads()) == {1}
    assert set(_threads()) == {2}


def _fails_inside() -> None:
    limit = BlasLimit()
    with limit.held(), limit.held():
        assert set(_threads()) == {1}
        raise ValueError


def test_blocks_within_each_other_and_one_that_fails_leave_blas_as_it_was() -> None:
    with pytest.raises(ValueError, match=r"^$"):
        _fails_inside()
    assert set(_threads()) == {2}
