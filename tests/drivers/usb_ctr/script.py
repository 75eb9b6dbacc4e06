"""A USB-CTR board as a script: requests in the order of the manual, answers as bytes, packets of scan data."""

from dataclasses import dataclass, field

from drivers.usb_ctr.pipe import UsbFault

Line = tuple[str, bytes | UsbFault | None]
"""A request as "command value index data" in hex, and its answer; None where it has none."""


@dataclass
class ScriptedPipe:
    """A ``UsbPipe``. It fails the test where a request is not the next line of the script."""

    script: list[Line]
    packets: list[bytes | UsbFault] = field(default_factory=list[bytes | UsbFault])
    product_id: int = 0x012E
    closed: bool = False
    claimed: bool = False
    listening: bool = False
    """Whether transfers wait for packets."""

    def ask(self, command: int, value: int, index: int, n_bytes: int) -> bytes:
        answer = self._next(f"{command:02x} {value:x} {index:x}")
        assert answer is not None
        return answer

    def tell(self, command: int, value: int, index: int, data: bytes) -> None:
        assert self._next(f"{command:02x} {value:x} {index:x} {data.hex()}".strip()) is None

    def packet(self) -> bytes:
        assert self.listening
        packet = self.packets.pop(0) if self.packets else b""
        if isinstance(packet, UsbFault):
            raise packet
        return packet

    def claim(self) -> None:
        self.claimed = True

    def clear_halt(self) -> None:
        assert self._next("clear halt 86") is None

    def begin_packets(self) -> None:
        self.listening = True

    def end_packets(self) -> None:
        self.listening = False

    def close(self) -> None:
        self.closed = True

    def _next(self, request: str) -> bytes | None:
        assert self.script, f"{request} was sent after the end of the script"
        expected, answer = self.script.pop(0)
        assert request == expected
        if isinstance(answer, UsbFault):
            raise answer
        return answer


SERIAL: Line = ("48 0 0", b"01234567")
VERSION: Line = ("52 0 0", b"\x02\x01")
WELL: Line = ("40 0 0", b"\x02\x01")
OVERRUN: Line = ("40 0 0", b"\x06\x01")
DONE: Line = ("40 0 0", b"\x20\x01")

OPEN: list[Line] = [SERIAL, VERSION]
COUNT: Line = ("18 0 0 0001000010", None)
START: list[Line] = [
    ("22 0 0", None),
    ("20 0 0 " + "00" * 33, None),
    ("clear halt 86", None),
    ("23 0 0", None),
    ("21 0 0 " + "00" * 14, None),
]
STOP: list[Line] = [("22 0 0", None), ("23 0 0", None), ("24 5 0", None)]
END: list[Line] = [WELL, *STOP]


def words(*counts: int) -> list[bytes]:
    """Give a packet for each sample of 16 bits."""
    return [count.to_bytes(2, "little") for count in counts]
