"""What GRBL's lines mean, and the bytes of commands (fact sheet, sections 3.1 to 3.3)."""

import re
from dataclasses import dataclass
from typing import Final, TypeAlias

LONGEST: Final = 256
"""Bytes after which a line without its end is noise: a status line with all fields has about 120."""

STATUS: Final = b"?"
JOG_CANCEL: Final = b"\x85"
SOFT_RESET: Final = b"\x18"
WHO: Final = b"$I\n"
"""Answered by ``[VER:``, ``[OPT:`` and ``ok``."""

SETTINGS: Final = b"$$\n"
UNLOCK: Final = b"$X\n"
HOME: Final = b"$H\n"

_STATUS = re.compile(r"<([A-Z][a-z]+)(?::(\d))?\|((?:[^|<>]+\|)*[^|<>]+)>")
_NUMBER = r"-?\d+\.\d+"
_PLACE = re.compile(rf"(MPos|WPos|WCO):({_NUMBER}),({_NUMBER}),({_NUMBER})")
_SETTING = re.compile(r"\$(\d{1,3})=(-?\d+(?:\.\d+)?)")
_CODE = re.compile(r"(error|ALARM):(\d{1,2})")


@dataclass(frozen=True)
class Okay:
    """``ok``: the line is parsed and queued. Not done."""


@dataclass(frozen=True)
class Refused:
    """``error:N``."""

    code: int


@dataclass(frozen=True)
class Alarm:
    """``ALARM:N``."""

    code: int


@dataclass(frozen=True)
class Report:
    """A status line."""

    state: str
    """``Idle``, ``Run``, ``Hold``, ``Jog``, ``Alarm``, ``Door``, ``Check``, ``Home`` or ``Sleep``."""

    sub_state: str
    """Digit behind the state; empty where there is none."""

    machine_mm: tuple[float, ...] | None
    """X, Y, Z in machine coordinates."""

    work_mm: tuple[float, ...] | None
    """X, Y, Z in work coordinates."""

    offset_mm: tuple[float, ...] | None
    """Machine coordinates minus work coordinates; only in some lines."""


@dataclass(frozen=True)
class Setting:
    """One line of ``$$``."""

    number: int
    value: float


@dataclass(frozen=True)
class Version:
    """``[VER:...]``."""

    text: str


@dataclass(frozen=True)
class Welcome:
    """The controller has just started or was reset."""


@dataclass(frozen=True)
class Other:
    """A message, an option, or noise."""

    line: bytes


Event: TypeAlias = Okay | Refused | Alarm | Report | Setting | Version | Welcome | Other


def jog_to(axis: str, target_mm: float, velocity_mm_s: float) -> bytes:
    r"""Give the bytes of a jog to a place in machine coordinates.

    >>> jog_to("X", 12.5, 25.0)
    b'$J=G53G90G21X12.5000F1500.000\n'
    """
    return f"$J=G53G90G21{axis}{target_mm:.4f}F{60 * velocity_mm_s:.3f}\n".encode("ascii")


def write_setting(number: int, value: float) -> bytes:
    r"""Give the bytes that set ``$number``.

    >>> write_setting(120, 50.0)
    b'$120=50.000\n'
    """
    return f"${number}={value:.3f}\n".encode("ascii")


def understand(line: bytes) -> Event:
    """Say what a line, without its end, means.

    >>> understand(b"<Jog|MPos:1.000,0.000,0.000|FS:1500,0>").state
    'Jog'
    """
    try:
        text = line.decode("ascii")
    except UnicodeDecodeError:
        return Other(line)
    if text == "ok":
        return Okay()
    if code := _CODE.fullmatch(text):
        return Refused(int(code[2])) if code[1] == "error" else Alarm(int(code[2]))
    if status := _STATUS.fullmatch(text):
        places = {
            found[1]: tuple(float(number) for number in found.groups()[1:])
            for field in status[3].split("|")
            if (found := _PLACE.fullmatch(field))
        }
        return Report(status[1], status[2] or "", places.get("MPos"), places.get("WPos"), places.get("WCO"))
    if setting := _SETTING.fullmatch(text):
        return Setting(int(setting[1]), float(setting[2]))
    if text.startswith("[VER:"):
        return Version(text[5:].rstrip("]:"))
    return Welcome() if text.startswith("Grbl ") else Other(line)
