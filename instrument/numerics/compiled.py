"""Loops over numbers as machine code.

Some of our work is made of many short steps, each dependent on the one before: a tracker's frame, a solver's iteration. There the
cost of numpy is the call, not the numbers. Such loops are written in plain Python on arrays, and compiled when they are imported:
never in the middle of a run. The code is kept on disk for the next process.
"""

from collections.abc import Callable
from typing import Any, Final, TypeVar, cast

import numba

_F = TypeVar("_F", bound=Callable[..., Any])

_REORDERED: Final = frozenset({"reassoc", "contract", "nsz", "arcp"})


def compiled(signature: str, *, sums_reordered: bool = False) -> Callable[[_F], _F]:
    """Compile a function for one signature. It lets other Python threads run meanwhile.

    Args:
        signature: types as numba writes them, such as ``"void(f4[::1], i8)"``. Other types of arrays are refused at the call.
        sums_reordered: let the compiler sum in any order, many terms at once. Without, every operation is done in the order
            written, so that a series may be cut anywhere and gives the same to the bit.
    """
    options: dict[str, Any] = {
        "nogil": True,
        "error_model": "numpy",
        "fastmath": set(_REORDERED) if sums_reordered else False,
    }

    def decorate(function: _F) -> _F:
        try:
            return cast("_F", numba.njit(signature, cache=True, **options)(function))
        except RuntimeError:  # no folder can be written to: compile in every process
            return cast("_F", numba.njit(signature, **options)(function))

    return decorate


def inlined(function: _F) -> _F:
    """Write a function out inside each compiled one that calls it, so that the compiler sees both as one."""
    return cast("_F", numba.njit(inline="always")(function))
