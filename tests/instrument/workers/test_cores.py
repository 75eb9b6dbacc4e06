"""As many processes as this one may use cores."""

import os

import pytest

from instrument.workers import Where


@pytest.mark.skipif(not hasattr(os, "sched_setaffinity"), reason="this system binds no process to a core")
def test_without_a_number_there_is_a_process_for_each_core_that_may_be_used() -> None:
    every = os.sched_getaffinity(0)
    try:
        os.sched_setaffinity(0, {min(every)})
        assert Where.of(None, None) == Where(processes=1)
    finally:
        os.sched_setaffinity(0, every)
    assert Where.of(None, None) == Where(processes=len(every))
    assert Where.of(3, "tcp://lab:8786") == Where(3, "tcp://lab:8786")
