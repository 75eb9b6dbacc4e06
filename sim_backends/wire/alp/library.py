"""The C surface: a table of real C function pointers, as ``ctypes.CDLL`` gives them (dlp7000.md 3.1, 3.2)."""

import ctypes
import logging
from collections import deque
from collections.abc import Callable
from typing import Any

from sim_backends.wire.alp.board import EmulatedAlpBoard
from sim_backends.wire.alp.codes import Code, Refused

_log = logging.getLogger(__name__)

_INT, _ID, _POINTER = ctypes.c_int32, ctypes.c_uint32, ctypes.c_void_p

SIGNATURES: dict[str, tuple[Any, ...]] = {
    "AlpDevAlloc": (_INT, _INT, _POINTER),
    "AlpDevHalt": (_ID,),
    "AlpDevFree": (_ID,),
    "AlpDevControl": (_ID, _INT, _INT),
    "AlpDevControlEx": (_ID, _INT, _POINTER),
    "AlpDevInquire": (_ID, _INT, _POINTER),
    "AlpSeqAlloc": (_ID, _INT, _INT, _POINTER),
    "AlpSeqFree": (_ID, _ID),
    "AlpSeqControl": (_ID, _ID, _INT, _INT),
    "AlpSeqTiming": (_ID, _ID, _INT, _INT, _INT, _INT, _INT),
    "AlpSeqInquire": (_ID, _ID, _INT, _POINTER),
    "AlpSeqPut": (_ID, _ID, _INT, _INT, _POINTER),
    "AlpSeqPutEx": (_ID, _ID, _POINTER, _POINTER),
    "AlpProjStart": (_ID, _ID),
    "AlpProjStartCont": (_ID, _ID),
    "AlpProjHalt": (_ID,),
    "AlpProjWait": (_ID,),
    "AlpProjControl": (_ID, _INT, _INT),
    "AlpProjControlEx": (_ID, _INT, _POINTER),
    "AlpProjInquire": (_ID, _INT, _POINTER),
    "AlpProjInquireEx": (_ID, _INT, _POINTER),
}
"""Argument types of each function; every one returns a 32-bit code."""

_REMEMBERED = 100_000
"""Calls that ``calls`` keeps."""


class AlpLibrary:
    """What loading the vendor's library would give: each function an attribute, a C function pointer without types.

    As with a real library the caller may set ``argtypes`` and ``restype``, and gets ``AttributeError`` for a function that
    the library has not. A call never raises; it returns a code.
    """

    def __init__(self, board: EmulatedAlpBoard) -> None:
        """Make the function pointers."""
        self.board = board
        self.calls: deque[tuple[str, int]] = deque(maxlen=_REMEMBERED)
        """Functions that were called and what they returned, in order."""
        methods: dict[str, Callable[..., None]] = {
            "AlpDevAlloc": board.dev_alloc,
            "AlpDevHalt": board.dev_halt,
            "AlpDevFree": board.dev_free,
            "AlpDevControl": board.dev_control,
            "AlpDevControlEx": board.dev_control_ex,
            "AlpDevInquire": board.dev_inquire,
            "AlpSeqAlloc": board.seq_alloc,
            "AlpSeqFree": board.seq_free,
            "AlpSeqControl": board.seq_control,
            "AlpSeqTiming": board.seq_timing,
            "AlpSeqInquire": board.seq_inquire,
            "AlpSeqPutEx": board.seq_put_ex,
            "AlpProjStart": board.proj_start,
            "AlpProjStartCont": board.proj_start_cont,
            "AlpProjHalt": board.proj_halt,
            "AlpProjControl": board.proj_control,
            "AlpProjControlEx": board.proj_control_ex,
            "AlpProjInquire": board.proj_inquire,
            "AlpProjInquireEx": board.proj_inquire_ex,
        }
        self._methods = methods
        # A pointer without argument types converts as a freshly loaded function does. The typed callback behind it has to
        # stay alive as long as the pointer.
        self._callbacks = {
            name: ctypes.CFUNCTYPE(_INT, *types)(self._entry(name)) for name, types in SIGNATURES.items()
        }
        untyped = ctypes.CFUNCTYPE(_INT)
        self._pointers: dict[str, Callable[..., int]] = {
            name: untyped(ctypes.cast(callback, _POINTER).value or 0) for name, callback in self._callbacks.items()
        }

    def __getattr__(self, name: str) -> Callable[..., int]:
        """Give a function of the library.

        Raises:
            AttributeError: it has no such function.
        """
        try:
            return self.__dict__["_pointers"][name]  # type: ignore[no-any-return]
        except KeyError:
            raise AttributeError(f"{name}: no such function in this ALP library") from None

    def _entry(self, name: str) -> Callable[..., int]:
        def entry(*arguments: Any) -> int:
            code = self._call(name, arguments)
            self.calls.append((name, code))
            return code

        return entry

    def _call(self, name: str, arguments: tuple[Any, ...]) -> int:
        try:
            fault = self.board.begin_call(name)
            if name == "AlpSeqPut":
                self.board.seq_put(*arguments, fault=fault)
            elif name == "AlpProjWait":
                self.board.proj_wait(*arguments)
            else:
                with self.board.locked():
                    self._methods[name](*arguments)
        except Refused as refused:
            return refused.code
        except Exception:  # noqa: BLE001 - nothing may escape through C
            _log.exception("the ALP emulator failed in %s", name)
            return Code.ERROR_UNKNOWN
        return Code.OK
