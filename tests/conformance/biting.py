"""What the tests of broken devices share."""

from collections.abc import Callable
from inspect import signature

import pytest

from protocols import KinopixError

FOUND = (AssertionError, pytest.fail.Exception, KinopixError)
"""How a test of a suite says that a device is broken."""


def call(test: Callable[..., None], **offered: object) -> None:
    """Call a test with those of the arguments that it asks for."""
    test(**{name: offered[name] for name in signature(test).parameters})
