"""Loops over numbers, compiled to machine code.

A tracker and a solver take many short steps, each of which depends on the one before. In numpy such a step would cost the call
rather than the arithmetic. These loops are therefore written in plain Python on arrays, and compiled when their module is
imported, so that no run waits for a compiler. The machine code is kept on disk for the next process. Where what is kept there
cannot be read, or nothing can be kept, the loops are compiled for this process alone: that costs time, and nothing else.
"""

import os
import warnings
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
        if _kept.usable:
            try:
                return cast("_F", numba.njit(signature, cache=True, **options)(function))
            except Exception as error:  # noqa: BLE001 - whatever comes of bytes that are unpickled; ours come again below
                _kept.fails(error)
        return cast("_F", numba.njit(signature, **options)(function))

    return decorate


class _Kept:
    """The folder of compiled code: whether it is of use, and whether that was told."""

    def __init__(self) -> None:
        self.usable = True
        """Whether to look into it: not after a disk was full, as each loop would be compiled twice."""

        self._told = False

    def fails(self, error: Exception) -> None:
        """Take note of an error in reading from the folder, or in writing to it, and tell the first."""
        if isinstance(error, OSError):
            self.usable = False
        if self._told or isinstance(error, RuntimeError):  # numba knows of no folder that can be written to: so it is
            return
        self._told = True
        folder = os.environ.get("NUMBA_CACHE_DIR") or "the folders __pycache__ of Kinopix"
        warnings.warn(
            f"kept machine code cannot be used ({type(error).__name__}: {error}), and is compiled anew, which takes some "
            f"seconds at every start. To do: make room for {folder}, or delete the files *.nbi and *.nbc in it.",
            RuntimeWarning,
            stacklevel=3,
        )


_kept = _Kept()


def inlined(function: _F) -> _F:
    """Copy a function into each compiled one that calls it, so that the compiler optimises both together."""
    return cast("_F", numba.njit(inline="always")(function))
