"""What all suites use: another thread, and what every error has to say."""

from collections.abc import Callable
from threading import Thread
from typing import Final, cast

from hypothesis import settings
from hypothesis.stateful import RuleBasedStateMachine, run_state_machine_as_test

from protocols.errors import KinopixError

PATIENCE_S: Final = 20.0
"""Longest real time that a call from another thread may take: no more than a guard against a dead lock."""

_QUICK: Final = settings(max_examples=20, stateful_step_count=15, deadline=None, derandomize=True, database=None)
"""A few hundred calls, the same each time."""


def in_another_thread(action: Callable[[], object]) -> None:
    """Call ``action`` in another thread, wait until it is over, and raise what it raised.

    Raises:
        AssertionError: it does not come back.
    """
    raised: list[BaseException] = []

    def run() -> None:
        try:
            action()
        except BaseException as error:  # noqa: BLE001 - handed over to the caller
            raised.append(error)

    thread = Thread(target=run, daemon=True)
    thread.start()
    thread.join(PATIENCE_S)
    assert not thread.is_alive(), f"the call does not come back in {PATIENCE_S:g} s: it waits for a lock"
    if raised:
        raise raised[0]


def error_of(action: Callable[[], object]) -> KinopixError | None:
    """What ``action`` raises on purpose, or None."""
    try:
        action()
    except KinopixError as error:
        return error
    return None


def assert_keeps_to_model(machine: Callable[[], RuleBasedStateMachine]) -> None:
    """Let Hypothesis look for an order of calls in which device and model part."""
    run_state_machine_as_test(cast("type[RuleBasedStateMachine]", machine), settings=_QUICK)


def assert_speaks(error: KinopixError, device: str) -> None:
    """Check that an error names its device, what was seen, what was expected, and what to do."""
    assert error.device == device, f"the error names {error.device!r}, the identity {device!r}"
    for part in (error.saw, error.expected, error.remedy):
        assert part.strip(), f"a part of the sentence is missing in {error}"
