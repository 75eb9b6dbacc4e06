"""Turn a loaded library, or what stands in for one, into an ``AlpApi``.

A real library gets its argument types: cdecl (``ctypes.CDLL``), 32-bit integers everywhere, pointers as ``void *``. Without
them ctypes would pass ids above 2**31 wrongly and could not catch a wrong call.
"""

import ctypes
from typing import Final, cast

from drivers.alp.api import AlpApi
from protocols.errors import DriverUnavailable

_INT, _ID, _POINTER = ctypes.c_int32, ctypes.c_uint32, ctypes.c_void_p

SIGNATURES: Final[dict[str, tuple[type, ...]]] = {
    "AlpDevAlloc": (_INT, _INT, _POINTER),
    "AlpDevHalt": (_ID,),
    "AlpDevFree": (_ID,),
    "AlpDevControl": (_ID, _INT, _INT),
    "AlpDevInquire": (_ID, _INT, _POINTER),
    "AlpSeqAlloc": (_ID, _INT, _INT, _POINTER),
    "AlpSeqFree": (_ID, _ID),
    "AlpSeqControl": (_ID, _ID, _INT, _INT),
    "AlpSeqTiming": (_ID, _ID, _INT, _INT, _INT, _INT, _INT),
    "AlpSeqInquire": (_ID, _ID, _INT, _POINTER),
    "AlpSeqPut": (_ID, _ID, _INT, _INT, _POINTER),
    "AlpProjStart": (_ID, _ID),
    "AlpProjControl": (_ID, _INT, _INT),
    "AlpProjControlEx": (_ID, _INT, _POINTER),
    "AlpProjInquire": (_ID, _INT, _POINTER),
    "AlpProjInquireEx": (_ID, _INT, _POINTER),
}
"""Argument types of each function (fact sheet 3.2). All return ``int32``."""


def bind(table: object, *, device: str = "dmd") -> AlpApi:
    """Check that ``table`` has every function of ``AlpApi`` and, where it is a C library, set its argument types.

    Raises:
        DriverUnavailable: functions are missing; names each.
    """
    missing = [name for name in SIGNATURES if not callable(getattr(table, name, None))]
    if missing:
        raise DriverUnavailable(
            device=device,
            saw=f"an ALP function table without {', '.join(missing)}",
            expected=f"the {len(SIGNATURES)} functions of the ALP-4 high-speed API",
            remedy="use the high-speed library (not alpV42basic.dll), or mend the transport named in bench.toml",
        )
    if isinstance(table, ctypes.CDLL):
        for name, arguments in SIGNATURES.items():
            function = getattr(table, name)
            function.argtypes, function.restype = list(arguments), _INT
    return cast("AlpApi", table)
