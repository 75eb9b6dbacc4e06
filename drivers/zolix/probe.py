"""Which controller is on the line (fact sheet, sections 1 and 3).

``VE`` first, because an idle SC300 also says ``OK``, to a lone CR; then ``Hello``; then a position, whose form only the MC600
has. Nothing that is asked can move anything.
"""

from typing import Final, Literal, TypeAlias

from drivers.serial_line import SerialPort
from drivers.zolix.events import BAUD, Lines
from protocols import Clock, DeviceDisconnected, DriverUnavailable

DialectName: TypeAlias = Literal["mc600", "sc300"]

_ROUNDS: Final = 2
"""A reply may be lost once; a half command from before may have spoiled the first question."""


def probe(
    port: SerialPort,
    clock: Clock,
    *,
    device: str,
    axis: str,
    dialect: DialectName | None = None,
    reply_s: float = 0.5,
    poll_s: float = 0.001,
) -> tuple[DialectName, str]:
    """Give the dialect and the firmware's name for itself (empty for an MC600, which does not tell).

    With ``dialect`` given, only that one is asked for.

    Raises:
        DriverUnavailable: no known controller answers; names all bytes seen.
        DeviceDisconnected: the port is gone.
    """
    try:
        port.reset_input_buffer()
        heard = _Hearing(port, clock, reply_s, poll_s)
        for _ in range(_ROUNDS):
            if dialect != "mc600" and (name := heard.ask(b"VE\r", b"SC300")):
                return "sc300", name.decode("ascii", "backslashreplace")
            if dialect == "sc300":
                continue
            greeted = heard.ask(b"Hello\r", b"OK")
            if greeted and heard.ask(f"Position? {axis}\r".encode("ascii"), f"POSITION? {axis}".encode("ascii")):
                return "mc600", ""
    except OSError as error:
        raise DeviceDisconnected(
            device=device,
            saw=f"a serial port that fails ({error})",
            expected="an open port",
            remedy="check the cable and the power, and open the stage again",
        ) from error
    raise DriverUnavailable(
        device=device,
        saw=f"{b' '.join(heard.lines)!r} in answer to the questions of {dialect or 'both dialects'}",
        expected="SC300... in answer to VE, or OK and POSITION? in answer to Hello and Position?",
        remedy="check power, cable (crossed or straight), 19200 baud, and the label on the controller; "
        "an SC300 in motion is mute, so wait until the stage stands",
    )


class _Hearing:
    """Questions to an unknown controller, and every line that came back."""

    def __init__(self, port: SerialPort, clock: Clock, reply_s: float, poll_s: float) -> None:
        self.lines: Final[list[bytes]] = []
        self._cutter = Lines()
        self._port = port
        self._clock = clock
        self._reply_s = reply_s
        self._poll_s = poll_s

    def ask(self, question: bytes, wanted: bytes) -> bytes | None:
        """Send ``question``; give the first line that contains ``wanted``, or None after a silence or another line."""
        self._port.write(question)
        until_s = self._clock.now_s() + self._reply_s + (len(question) + 64) * 10 / BAUD
        while self._clock.now_s() < until_s:
            for line in self._cutter.feed(self._port.read(self._port.in_waiting) if self._port.in_waiting else b""):
                self.lines.append(line)
                if wanted in line.upper():
                    return line
                if line.startswith(b"E"):
                    return None
            self._clock.sleep_s(self._poll_s)
        self._cutter.discard()
        return None
