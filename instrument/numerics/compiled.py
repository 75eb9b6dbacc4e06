"""Loops over numbers as machine code.

Some of our work is made of many short steps, each dependent on the one before: a tracker's frame, a solver's iteration. There the
cost of numpy is the call, not the numbers. Such loops are written in plain Python on arrays, and compiled when they are imported:
never in the middle of a run. The code is kept on disk for the next process. Where what is kept there cannot be read, or nothing
can be kept, it is compiled for this process alone: that costs time, and nothing else.
"""

import os
import warnings
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
    """Write a function out inside each compiled one that calls it, so that the compiler sees both as one."""
    return cast("_F", numba.njit(inline="always")(function))
