"""Loops over numbers, compiled to machine code.

A tracker and a solver take many short steps, each of which depends on the one before. In numpy such a step would cost the call
rather than the arithmetic. These loops are therefore written in plain Python on arrays, and compiled when their module is
imported, so that no run waits for a compiler. The machine code is kept on disk for the next process.
"""

from collections.abc import Callable
from typing import Any, Final, TypeVar, cast

import numba

_F = TypeVar("_F", bound=Callable[..., Any])

_REORDERED: Final = frozenset({"reassoc", "contract", "nsz", "arcp"})


def compiled(signature: str, *, sums_reordered: bool = False) -> Callable[[_F], _F]:
    """Compile a function for one signature. Other Python threads can run while it works.

    Args:
        signature: types as numba writes them, such as ``"void(f4[::1], i8)"``. A call with other types of arrays is refused.
        sums_reordered: whether the compiler may sum in any order, many terms at once. Otherwise every operation is done in the
            order written, so that a series that is cut into pieces gives the same result to the bit.
    """
    options: dict[str, Any] = {
        "nogil": True,
        "error_model": "numpy",
        "fastmath": set(_REORDERED) if sums_reordered else False,
    }

    def decorate(function: _F) -> _F:
        try:
            return cast("_F", numba.njit(signature, cache=True, **options)(function))
        except RuntimeError:  # numba finds no folder to write to, and compiles in every process
            return cast("_F", numba.njit(signature, **options)(function))

    return decorate


def inlined(function: _F) -> _F:
    """Copy a function into each compiled one that calls it, so that the compiler optimises both together."""
    return cast("_F", numba.njit(inline="always")(function))
