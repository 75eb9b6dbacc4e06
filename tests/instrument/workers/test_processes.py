"""Processes of this computer that do jobs: one that dies takes its own job alone."""

import os
from typing import Any

from instrument.workers import Failure, Job, Where, carry_out


def test_a_process_that_dies_takes_its_own_job_alone() -> None:
    """As the system ends one where memory is short."""
    done: dict[int, tuple[Any, Failure | None]] = {}

    def take(number: int, result: Any, failure: Failure | None) -> None:
        assert number not in done
        done[number] = result, failure

    carry_out([Job("dies", os._exit, (9,)), Job("good", len, ("abc",))], Where(processes=2), take)
    assert done[1] == (3, None)
    result, failure = done[0]
    assert result is None
    assert failure is not None
    assert "its process ended" in failure.why
