"""Ten minutes that settle the open questions about a Zolix controller: every byte, with its time, into a text file.

    python examples/capture_zolix.py COM3 mc600 --axis X --pulses 1000 --long-pulses 20000 --out capture.txt

Only pyserial is needed. Each step that moves the stage is announced and waits for Enter; Ctrl-C sends a stop. Numbers are in the
controller's own unit: on an MC600 the unit is set to pulses first. Begin near the middle of the travel, with the load off.
"""

import argparse
import time
from collections.abc import Iterable
from pathlib import Path
from typing import NamedTuple, TextIO

import serial


class Step(NamedTuple):
    """One thing to send, and how long to listen after it."""

    what: str
    sends: bytes
    listen_s: float = 1.0
    moves: bool = False


def mc600(axis: str, pulses: int, long_pulses: int) -> list[Step]:
    """Identify, set, query, short move, long move with queries, stop, home, limit switch."""
    ask, stop = f"Position? {axis}\r".encode(), f"Stop {axis}\r".encode()
    return [
        Step("which controller (question 1)", b"VE\r"),
        Step("link test", b"Hello\r"),
        Step("unit as it was", f"SetUnit? {axis}\r".encode()),
        Step("unit to pulses", f"SetUnit {axis},s\r".encode()),
        Step("lead", f"SetStagePitch? {axis}\r".encode()),
        Step("pulses a turn", f"SetStageStepsRev? {axis}\r".encode()),
        Step("velocity", f"SetSpeed? {axis}\r".encode()),
        Step("start velocity", f"SetInitSpeed? {axis}\r".encode()),
        Step("acceleration", f"SetAccSpeed? {axis}\r".encode()),
        Step("homing velocity", f"SetHomeSpeed? {axis}\r".encode()),
        Step("unknown command (question 6)", b"Nonsense\r"),
        Step("position", ask),
        Step("short move (question 3)", f"GoPosition {axis},O,R,P,{pulses}\r".encode(), 10, moves=True),
        Step("position", ask),
        Step("move of length zero", f"GoPosition {axis},O,R,P,0\r".encode(), 3),
        Step("long move", f"GoPosition {axis},O,R,P,{long_pulses}\r".encode(), 0.5, moves=True),
        Step("position on the way (question 4)", ask, 0.3),
        Step("position on the way", ask, 0.3),
        Step("second move on the way (question 6)", f"GoPosition {axis},O,R,P,{pulses}\r".encode(), 0.3),
        Step("stop on the way (questions 4 and 5)", stop, 5),
        Step("stop while standing", stop),
        Step("position", ask),
        Step("home (question 7)", f"GoHome {axis}\r".encode(), 120, moves=True),
        Step("position after homing", ask),
        Step(
            "into the limit switch: hold it by hand now", f"GoPosition {axis},O,R,P,{pulses}\r".encode(), 10, moves=True
        ),
        Step("position", ask),
    ]


def sc300(axis: str, pulses: int, long_pulses: int) -> list[Step]:
    """Give the same for an SC300."""
    ask, stop = f"?{axis}\r".encode(), f"SP{axis}\r".encode()
    return [
        Step("which controller (question 1)", b"VE\r"),
        Step("model", b"TY\r"),
        Step("id", b"ID\r"),
        Step("lone CR", b"\r"),
        Step("velocity", f"{axis}V\r".encode()),
        Step("start velocity", f"{axis}F\r".encode()),
        Step("acceleration", f"{axis}A\r".encode()),
        Step("unknown command (question 6)", b"QQ\r"),
        Step("position", ask),
        Step("short move (question 3)", f"+{axis},{pulses}\r".encode(), 10, moves=True),
        Step("position", ask),
        Step("move of length zero", f"+{axis},0\r".encode(), 3),
        Step("long move", f"+{axis},{long_pulses}\r".encode(), 0.5, moves=True),
        Step("position on the way (question 4)", ask, 0.5),
        Step("lone CR on the way", b"\r", 0.5),
        Step("stop on the way (questions 4 and 5)", stop, 5),
        Step("stop while standing", stop),
        Step("position", ask),
        Step("home (question 7)", f"H{axis}\r".encode(), 120, moves=True),
        Step("position after homing", ask),
        Step("into the limit switch: hold it by hand now", f"+{axis},{pulses}\r".encode(), 10, moves=True),
        Step("position", ask),
    ]


def capture(port: serial.Serial, steps: Iterable[Step], log: TextIO) -> None:
    """Send each step and write what is sent and heard, with seconds since the beginning."""
    zero_s = time.monotonic()

    def write(direction: str, data: bytes) -> None:
        line = f"{time.monotonic() - zero_s:10.4f} {direction} {data.hex(' ')}  {data!r}"
        print(line)
        log.write(line + "\n")
        log.flush()

    for step in steps:
        log.write(f"# {step.what}\n")
        print(f"# {step.what}")
        if step.moves:
            input("  the stage will MOVE: Enter to go on, Ctrl-C to end ")
        write(">", step.sends)
        port.write(step.sends)
        until_s = time.monotonic() + step.listen_s
        while time.monotonic() < until_s:
            if heard := port.read(max(1, port.in_waiting)):
                write("<", heard)


def main() -> None:
    """Read the command line, open the port, capture; stop the stage on every way out."""
    parser = argparse.ArgumentParser(description="Log the bytes of a Zolix controller, with their times.")
    parser.add_argument("port")
    parser.add_argument("dialect", choices=["mc600", "sc300"])
    parser.add_argument("--axis", default="X")
    parser.add_argument("--pulses", type=int, default=1000, help="length of the short move")
    parser.add_argument("--long-pulses", type=int, default=20000, help="length of the long move")
    parser.add_argument("--out", type=Path, default=Path("capture.txt"))
    given = parser.parse_args()
    plan = mc600 if given.dialect == "mc600" else sc300
    steps = plan(given.axis, given.pulses, given.long_pulses)
    stop = next(step.sends for step in steps if step.what == "stop while standing")
    with (
        serial.serial_for_url(given.port, baudrate=19200, timeout=0.01) as port,
        given.out.open("w", encoding="utf-8") as log,
    ):
        try:
            capture(port, steps, log)
        finally:
            port.write(stop)
            port.flush()


if __name__ == "__main__":
    main()
