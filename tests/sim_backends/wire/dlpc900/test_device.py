"""The emulated board, by the sheet's own packets (dlpc900.md, sections 2, 3, 4 and 8)."""

import struct
from typing import Any

import numpy as np
import pytest

from sim_backends.bench import OpticalBench, SceneSettings
from sim_backends.wire.dlpc900 import Dlpc900EmulatorSettings, EmulatedDlpc900


class Host:
    """Sends packets and reads replies."""

    def __init__(self, **settings: Any) -> None:
        self.bench = OpticalBench(SceneSettings())
        self.device = EmulatedDlpc900(Dlpc900EmulatorSettings.model_validate(settings), self.bench)

    def send(self, packet: bytes) -> bytes:
        """Give the reply without its filling, or nothing."""
        packet += bytes(-len(packet) % 64)
        for at in range(0, len(packet), 64):
            self.device.write(packet[at : at + 64])
        reply = self.device.read(0.01)
        return reply[: 4 + struct.unpack("<H", reply[2:4])[0]] if reply else b""

    def set(self, command: int, data: str = "") -> int:
        """Give the error, 0 for none."""
        body = bytes.fromhex(data)
        reply = self.send(struct.pack("<BBHH", 0x40, 7, len(body) + 2, command) + body)
        assert reply[1] == 7
        return self.ask(0x0100)[0] if reply[0] & 0x20 else 0

    def ask(self, command: int) -> bytes:
        """Give the data of the answer."""
        return self.send(struct.pack("<BBHH", 0xC0, 9, 2, command))[4:]


def dark_image(rows: int = 1080, columns: int = 1920) -> bytes:
    """Every mirror dark: one line, and the others like it."""
    line = b"\x80\x0f\x00\x00\x00" if columns == 1920 else b"\x80\x0a\x00\x00\x00"
    n = columns
    body = line + (b"\x00\x01" + bytes([n & 0x7F | 0x80, n >> 7])) * (rows - 1) + b"\x00\x01\x00"
    body += bytes(-len(body) % 4)
    header = b"Spld" + struct.pack("<HHI", columns, rows, len(body)) + b"\xff" * 8 + bytes(5) + b"\x02\x01" + bytes(21)
    return header + body


def upload(host: Host, number: int, image: bytes, begin: int = 0x1A2A) -> int:
    """Give the first error."""
    error = host.set(begin, struct.pack("<HI", number, len(image)).hex())
    for at in range(0, len(image), 504):
        part = image[at : at + 504]
        error = error or host.set(begin + 1, (struct.pack("<H", len(part)) + part).hex())
    return error


def test_the_reply_has_the_form_of_the_guide() -> None:
    """`C0 11 02 00 ...` is answered by `C0 11`, the length and the data."""
    host = Host()
    assert host.send(bytes.fromhex("C0 11 02 00 0C 1A")) == bytes.fromhex("C0 11 01 00 00")
    assert host.send(bytes.fromhex("C0 12 02 00 06 02")) == b"\xc0\x12\x20\x00\x01" + b"DLP6500".ljust(31, b"\0")
    assert host.ask(0x0205)[:4] == bytes.fromhex("02 00 00 06")


def test_an_unknown_command_has_the_error_flag_and_code_3_once() -> None:
    host = Host()
    assert host.send(bytes.fromhex("40 01 02 00 99 99")) == bytes.fromhex("60 01 00 00")
    assert host.ask(0x0100) == b"\x03"
    assert host.ask(0x0100) == b"\x00"


def test_a_write_without_the_reply_flag_is_not_answered() -> None:
    assert Host().send(bytes.fromhex("00 01 03 00 1B 1A 03")) == b""


def test_a_reply_that_is_not_fetched_is_overwritten() -> None:
    host = Host()
    host.device.write(bytes.fromhex("C0 01 02 00 05 02").ljust(64, b"\0"))
    assert host.send(bytes.fromhex("C0 02 02 00 0C 1A"))[:2] == b"\xc0\x02"


@pytest.mark.parametrize(
    ("data", "code"),
    [
        ("0000 C80000 10 000000 00 0000", 0),
        ("0000 690000 10 000000 00 0000", 0),  # 105 us
        ("0000 680000 10 000000 00 0000", 14),
        ("0002 C80000 10 000000 00 0000", 15),
        ("0000 C80000 10 000000 00 00C0", 10),
        ("0000 C80000 10 000000 00 1200", 17),
        ("0000 C80000 10", 6),
    ],
)
def test_a_definition_is_checked(data: str, code: int) -> None:
    host = Host()
    host.set(0x1A1B, "03")
    assert host.set(0x1A34, data) == code


def test_modes_and_order_are_checked() -> None:
    host = Host()
    assert host.ask(0x1A1B) == b"\x01"
    assert host.set(0x1A2A, "0000 40000000") == 5  # images are for the on-the-fly mode
    assert host.set(0x1A1B, "04") == 6
    assert host.set(0x1A1B, "03") == 0
    assert host.set(0x1A24, "02") == 5  # nothing is configured
    assert host.set(0x1A34, "0000 C80000 10 000000 00 0000") == 0
    assert host.set(0x1A31, "0100 01000000") == 7  # its image is missing
    assert upload(host, 0, dark_image()) == 0
    assert host.set(0x1A31, "0200 01000000") == 6
    assert host.set(0x1A31, "0100 01000000") == 0
    assert host.set(0x1A24, "02") == 0
    assert host.set(0x1A1E, "00 0000 1400") == 5  # it runs
    assert host.set(0x1A24, "00") == 0


def test_images_come_last_index_first() -> None:
    host = Host()
    host.set(0x1A1B, "03")
    assert upload(host, 1, dark_image()) == 0
    assert upload(host, 0, dark_image()) == 0
    assert upload(host, 1, dark_image()) == 17


@pytest.mark.parametrize("spoil", ["signature", "size", "code"])
def test_an_image_that_cannot_be_decoded_is_refused(spoil: str) -> None:
    host, image = Host(), bytearray(dark_image())
    host.set(0x1A1B, "03")
    image[{"signature": 0, "size": 6, "code": 48}[spoil]] ^= 1
    assert upload(host, 0, bytes(image)) == 9


@pytest.mark.parametrize(
    ("data", "code"), [("00 ECFF 0000", 0), ("00 EBFF 0000", 13), ("00 0000 0000", 13), ("01 1400 0000", 0)]
)
def test_trigger_delays_are_checked_and_kept(data: str, code: int) -> None:
    host = Host()
    assert host.set(0x1A1E, data) == code
    assert host.ask(0x1A1E) == (bytes.fromhex(data) if not code else bytes.fromhex("00 0000 1400"))


def test_it_plays_the_table_once_and_gives_an_edge_for_each_picture_that_has_one() -> None:
    host = Host(start_delay_s=0.001)
    host.set(0x1A1B, "03")
    for entry, edge in enumerate("010"):
        host.set(0x1A34, f"0{entry}00 C80000 10 000000 0{edge} 0000")
    upload(host, 0, dark_image())
    host.set(0x1A31, "0300 01000000")
    host.set(0x1A24, "02")
    assert host.ask(0x1A0C) == b"\x02"
    host.bench.clock.sleep_s(0.01)
    assert host.ask(0x1A0C) == b"\x00"
    edges = host.bench.edges(0, host.bench.clock.now_s()).time_s
    np.testing.assert_allclose(np.diff(edges), [4e-4], rtol=1e-6)


def test_two_controllers_want_both_halves() -> None:
    host = Host(model="DLP9000")
    host.set(0x1A1B, "03")
    host.set(0x1A34, "0000 C80000 10 000000 00 0000")
    half = dark_image(1600, 1280)
    assert upload(host, 0, half) == 0
    assert host.set(0x1A31, "0100 01000000") == 7
    assert upload(host, 0, half, 0x1A2C) == 0
    assert host.set(0x1A31, "0100 01000000") == 0
    assert host.ask(0x1A0A) == b"\x11"
    assert Host(model="DLP9000", second_controller=False).ask(0x1A0A) == b"\x01"


def test_one_controller_has_no_second_half() -> None:
    host = Host()
    host.set(0x1A1B, "03")
    assert host.set(0x1A2C, "0000 40000000") == 6


def fault(**keys: Any) -> Host:
    return Host(faults=[keys])


def test_faults_strike_what_they_name() -> None:
    assert fault(kind="error", command=0x1A1B, code=2).set(0x1A1B, "03") == 2
    assert fault(kind="lost-reply", command=0x1A0C).ask(0x1A0C) == b""
    wrong = fault(kind="wrong-echo", command=0x1A0C)
    assert wrong.send(bytes.fromhex("C0 11 02 00 0C 1A"))[1] == 0x10
    gone = fault(kind="unplugged", nth=2)
    gone.ask(0x1A0C)
    with pytest.raises(OSError, match="no such device"):
        gone.ask(0x1A0C)
    lost = fault(kind="lost-report", nth=1)
    assert lost.ask(0x1A0C) == b""
    assert lost.ask(0x1A0C) == b"\x00"
