"""Packets of Zaber's ASCII protocol: commands out, replies in (fact sheet, section 2.1)."""

import re
from dataclasses import dataclass
from typing import Final

LONGEST: Final = 80
"""Bytes of the longest packet."""

IDS: Final = 100
"""Message ids are 0 to 99: two digits on the wire."""

_REPLY = re.compile(
    r"@(?P<device>\d\d) (?P<axis>\d) (?P<id>\d\d) (?P<flag>OK|RJ) (?P<status>BUSY|IDLE) "
    r"(?P<warning>--|[A-Z]{2})(?: (?P<data>.*))?"
)
_CONTINUED = re.compile(r"#(?P<device>\d\d) (?P<axis>\d) (?P<id>\d\d) cont (?P<data>.*)")


def checksum(text: str) -> str:
    """Give the two hexadecimal digits of the two's complement of the sum of the bytes after the type character.

    Args:
        text: a packet without its type character and without ``:``.

    >>> checksum("01 tools echo"), checksum("1 0 01 move abs 10000")
    ('8F', 'C0')
    """
    return f"{-sum(text.encode('ascii')) & 0xFF:02X}"


def command(device: int, axis: int, message_id: int, words: str) -> bytes:
    r"""Give the bytes of a command with message id and checksum.

    >>> command(1, 0, 2, "get pos")
    b'/1 0 02 get pos:2B\n'
    """
    text = f"{device} {axis} {message_id:02d} {words}"
    return f"/{text}:{checksum(text)}\n".encode("ascii")


@dataclass(frozen=True)
class Reply:
    """A reply to one command."""

    device: int
    axis: int
    message_id: int

    accepted: bool
    """``OK``, not ``RJ``."""

    busy: bool
    """Whether the axis moves."""

    warning: str
    """The flag of highest priority, two letters; empty where there is none."""

    data: str
    """Answer, or the reason why the command was rejected."""

    more: bool = False
    """Whether the rest comes in info packets."""

    checked: bool = False
    """Whether it carried a checksum, which fits."""


@dataclass(frozen=True)
class Continuation:
    """The rest of a reply that was too long for one packet."""

    device: int
    axis: int
    message_id: int
    data: str
    more: bool = False


def parse(line: bytes, *, unchecked: bool = True) -> Reply | Continuation | None:
    r"""Give what a line means to somebody who asked; None for alerts, infos, damaged lines and others' traffic.

    Args:
        line: without its end.
        unchecked: whether lines without checksum mean anything.

    >>> parse(b"@01 0 02 OK IDLE -- 10000:4A")
    Reply(device=1, axis=0, message_id=2, accepted=True, busy=False, warning='', data='10000', more=False, checked=True)
    >>> parse(b"@01 0 02 OK IDLE -- 10001:4A") is None
    True
    """
    try:
        text = line.decode("ascii")
    except UnicodeDecodeError:
        return None
    text, colon, digits = text.partition(":")
    if digits != checksum(text[1:]) if colon else not unchecked:
        return None
    more = text.endswith("\\")
    text = text.rstrip("\\")
    if reply := _REPLY.fullmatch(text):
        return Reply(
            device=int(reply["device"]),
            axis=int(reply["axis"]),
            message_id=int(reply["id"]),
            accepted=reply["flag"] == "OK",
            busy=reply["status"] == "BUSY",
            warning=reply["warning"].strip("-"),
            data=reply["data"] or "",
            more=more,
            checked=bool(colon),
        )
    if rest := _CONTINUED.fullmatch(text):
        device, axis, message_id = int(rest["device"]), int(rest["axis"]), int(rest["id"])
        return Continuation(device, axis, message_id, rest["data"], more)
    return None
