"""Every return code of the ALP library as a typed error that says what to do (meanings: fact sheet 3.3).

Which code a violation gives is not fully known, so every code is answered after every call, the unknown ones too.
"""

from typing import Final, Literal, NamedTuple, TypeAlias

from drivers.alp.constants import ReturnCode
from protocols.errors import DeviceBusy, DeviceDisconnected, DeviceError, DeviceRefused, DriverUnavailable, WrongState

Kind: TypeAlias = Literal["busy", "gone", "unavailable", "refused", "stopped"]


class _Meaning(NamedTuple):
    kind: Kind
    what: str
    remedy: str


_POWER_CYCLE = "switch the board off for ten seconds and on again, and look at its status lights"
_REPORT = "please report it with the library's version (`kinopix drivers`) and the code"

_MEANINGS: Final[dict[int, _Meaning]] = {
    ReturnCode.NOT_ONLINE: _Meaning(
        "gone", "no board that is ready", "check the board's power, its USB cable and the ViALUX driver"
    ),
    ReturnCode.NOT_IDLE: _Meaning(
        "busy", "the board is not idle", "halt the board first, or wait until it has finished"
    ),
    ReturnCode.NOT_AVAILABLE: _Meaning(
        "refused", "the device id is not valid", "close the device and open it again; it was freed or reset meanwhile"
    ),
    ReturnCode.NOT_READY: _Meaning(
        "busy",
        "the board is held by another program, or by one that was killed",
        f"close the other program that uses the board; where it was killed, {_POWER_CYCLE}",
    ),
    ReturnCode.PARM_INVALID: _Meaning(
        "refused",
        "a parameter is out of range",
        "compare the plan's picture time and sync width with the board's limits",
    ),
    ReturnCode.ADDR_INVALID: _Meaning("refused", "user data or a sequence id is not valid", "load the patterns again"),
    ReturnCode.MEMORY_FULL: _Meaning(
        "refused", "not enough pattern memory in one piece", "record fewer frames a run, or open the device afresh"
    ),
    ReturnCode.SEQ_IN_USE: _Meaning("busy", "the sequence is being shown", "halt the board first"),
    ReturnCode.HALTED: _Meaning(
        "stopped", "a halt stopped the upload", "load the patterns again, once nobody halts the board any more"
    ),
    ReturnCode.ERROR_INIT: _Meaning("refused", "the board could not initialise", _POWER_CYCLE),
    ReturnCode.ERROR_COMM: _Meaning(
        "gone", "communication with the board broke", "check the USB cable, use no hub, and open the device again"
    ),
    ReturnCode.DEVICE_REMOVED: _Meaning(
        "gone", "the board was unplugged", "plug the board in again and open the device anew"
    ),
    ReturnCode.NOT_CONFIGURED: _Meaning("refused", "the board's FPGA is not configured", _POWER_CYCLE),
    ReturnCode.LOADER_VERSION: _Meaning(
        "unavailable",
        "the USB driver is too old for this function",
        "install the USB driver that came with the library",
    ),
    ReturnCode.ERROR_POWER_DOWN: _Meaning("refused", "the mirrors do not wake from their parked state", _POWER_CYCLE),
    ReturnCode.DRIVER_VERSION: _Meaning(
        "unavailable",
        "the ViALUX driver does not match the library",
        "update the ViALUX drivers, then power-cycle the board",
    ),
    ReturnCode.SDRAM_INIT: _Meaning("refused", "the board's memory did not initialise", _POWER_CYCLE),
    ReturnCode.CONFIG_MISMATCH: _Meaning(
        "refused",
        "the board is not configured for this call",
        'check the ALP version of the board, or set flut = "off"',
    ),
    ReturnCode.ERROR_UNKNOWN: _Meaning("refused", "an error that the library does not explain", _REPORT),
}

_NOT_THERE: Final = _Meaning(
    "gone",
    "no board that is ready, asked for two seconds; or one that another program holds, as one laboratory saw",
    "check the board's power, its USB cable and the ViALUX driver, and close other programs that use the board",
)


def error_of(code: int, call: str, device: str) -> DeviceError:
    """Give the error for return code ``code`` (not 0) of the function ``call``, such as ``"AlpSeqPut"``.

    A board that is not there is ``DriverUnavailable`` when it is looked for and ``DeviceDisconnected`` later.
    """
    name = f"ALP_{ReturnCode(code).name}" if code in _MEANINGS else "a code that no known header explains"
    meaning = _MEANINGS.get(code) or _Meaning("refused", "unknown", _REPORT)
    if call == "AlpDevAlloc" and code == ReturnCode.NOT_ONLINE:
        meaning = _NOT_THERE
    saw = f"{call} answer {name}: {meaning.what}"
    expected, remedy = "ALP_OK", meaning.remedy
    coded = f"{saw} (code {code})"
    match meaning.kind:
        case "busy":
            return DeviceBusy(device=device, saw=coded, expected=expected, remedy=remedy)
        case "stopped":
            return WrongState(device=device, saw=coded, expected=expected, remedy=remedy)
        case "unavailable":
            return DriverUnavailable(device=device, saw=coded, expected=expected, remedy=remedy)
        case "gone" if call == "AlpDevAlloc":
            return DriverUnavailable(device=device, saw=coded, expected=expected, remedy=remedy)
        case "gone":
            return DeviceDisconnected(device=device, saw=coded, expected=expected, remedy=remedy)
        case "refused":
            return DeviceRefused(device, code=str(code), saw=saw, expected=expected, remedy=remedy)
