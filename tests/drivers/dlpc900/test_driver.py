"""The driver on a board that answers each command as it is told, and keeps what it was sent."""

import struct

import numpy as np
import pytest

from drivers.dlpc900.driver import Dlpc900
from drivers.dlpc900.settings import Dlpc900Settings
from drivers.dlpc900.transport import HidReports
from protocols import (
    BenchContext,
    DeviceDisconnected,
    DeviceError,
    DeviceRefused,
    DeviceTimeout,
    DriverUnavailable,
    InputError,
    ModulatorTiming,
    PatternSequence,
    PixelGrid,
    PlanError,
    WrongState,
)
from tests.drivers.serial_line.scripted import Clock

SLOW = ModulatorTiming(picture_time_us=200)


class Board:
    """Takes packets apart; answers reads from a table, and writes with good news."""

    def __init__(self) -> None:
        self.clock = Clock()
        self.sent: list[tuple[int, int, bytes]] = []
        self.answers: dict[int, bytes] = {
            0x0100: b"\x00",
            0x0205: struct.pack("<4I", *[6 << 24 | 2] * 4),
            0x0206: b"\x01" + b"DLP6500".ljust(31, b"\0"),
            0x1A0A: b"\x01",
            0x1A0B: b"\x01",
            0x1A0C: b"\x00",
            0x1A1E: struct.pack("<Bhh", 0, 0, 20),
        }
        self.fails: dict[int, int] = {}
        self.mute = self.gone = self.closed = False
        self.stale = b""
        self._part = b""
        self._replies: list[bytes] = []

    def write(self, report: bytes) -> None:
        if self.gone:
            raise OSError("no such device")
        assert len(report) == 64
        self._part += report
        flags, sequence, length, command = struct.unpack("<BBHH", self._part[:6])
        if len(self._part) < 4 + length:
            return
        data, self._part = self._part[6 : 4 + length], b""
        self.sent.append((flags, command, data))
        if self.mute or not flags & 0x40:
            return
        error = 0x20 if command in self.fails else 0
        if error:
            self.answers[0x0100] = bytes([self.fails[command]])
        answer = self.answers.get(command, b"") if flags & 0x80 else b""
        reply = struct.pack("<BBH", flags | error, sequence, len(answer)) + answer
        if self.stale:
            self._replies.append(self.stale)
        self._replies += [reply[at : at + 64].ljust(64, b"\0") for at in range(0, len(reply), 64)]

    def read(self, timeout_s: float) -> bytes:
        if self._replies:
            return self._replies.pop(0)
        self.clock.sleep_s(timeout_s)
        return b""

    def close(self) -> None:
        self.closed = True

    def of(self, command: int) -> list[bytes]:
        return [data for _, sent, data in self.sent if sent == command]


def opened(board: Board) -> Dlpc900:
    assert isinstance(board, HidReports)
    return Dlpc900(Dlpc900Settings(), BenchContext(clock=board.clock, transport=board))


def sequence(n: int, columns: int = 1920, rows: int = 1080) -> PatternSequence:
    planes = np.zeros((n + 1, 8, 1), np.uint8)
    planes[1:, 0, 0] = 1 + np.arange(n) % 255
    planes[1:, 1, 0] = np.arange(n) >> 8
    return PatternSequence(
        planes, np.append(1 + np.arange(n), 0), PixelGrid(image_size=8, superpixel=8, columns=columns, rows=rows), 8
    )


def test_opening_asks_who_is_there_and_whether_it_is_well_and_stops_it() -> None:
    board = Board()
    dmd = opened(board)
    assert (dmd.identity.model, dmd.identity.firmware) == ("DLPC900 with DLP6500", "6.0.2")
    assert (dmd.limits.columns, dmd.limits.rows, dmd.limits.shortest_picture_time_us) == (1920, 1080, 105)
    assert board.sent[0][:2] == (0xC0, 0x0206)
    assert board.sent[-1] == (0x40, 0x1A24, b"\x00")


def test_the_longest_upload_is_that_of_a_picture_that_does_not_compress() -> None:
    """24 planes of 1920 x 1080 in 20 s: 0.833 s each."""
    assert opened(Board()).limits.longest_upload_s == pytest.approx(20 / 24, rel=0.01)


def test_a_load_is_mode_table_images_in_reverse_configuration_trigger() -> None:
    board = Board()
    dmd = opened(board)
    board.sent.clear()
    told: list[int] = []
    kept = dmd.load(sequence(30), SLOW, lambda stored, _total: told.append(stored))
    commands = [command for _, command, _ in board.sent]
    assert commands[:3] == [0x1A24, 0x1A1B, 0x1A24]  # stopped before and after the change of mode
    assert board.of(0x1A1B) == [b"\x03"]
    definitions = board.of(0x1A34)
    assert len(definitions) == 31
    assert definitions[0] == bytes.fromhex("0000 C80000 70 000000 00 0008")  # picture 0: 200 us, plane 1: image 0 bit 1
    assert definitions[23] == bytes.fromhex("1700 C80000 70 000000 00 0100")  # picture 23: plane 24: image 1 bit 0
    assert [struct.unpack("<H", data[:2])[0] for data in board.of(0x1A2A)] == [1, 0]
    assert all(len(data) <= 506 for data in board.of(0x1A2B))
    assert {flags for flags, command, _ in board.sent if command == 0x1A2B} == {0}
    assert board.of(0x1A31) == [bytes.fromhex("1F00 01000000")]
    assert board.of(0x1A1E)[0] == bytes.fromhex("00 0000 1400")
    assert commands.index(0x1A31) > max(k for k, command in enumerate(commands) if command == 0x1A2B)
    assert (kept.picture_time_us, kept.sync_delay_us, kept.sync_width_us) == (200, 0, 20)
    assert told[-1] == 31


def test_declared_and_sent_sizes_agree() -> None:
    board = Board()
    opened(board).load(sequence(3), SLOW)
    (begin,) = board.of(0x1A2A)
    assert struct.unpack("<I", begin[2:])[0] == sum(struct.unpack("<H", data[:2])[0] for data in board.of(0x1A2B))


def test_the_trigger_comes_before_its_picture_where_asked() -> None:
    board = Board()
    dmd = opened(board)
    board.answers[0x1A1E] = struct.pack("<Bhh", 0, -15, 15)
    kept = dmd.load(sequence(3), SLOW.model_copy(update={"sync_delay_us": 15, "sync_width_us": 30}))
    assert board.of(0x1A1E)[0] == struct.pack("<Bhh", 0, -15, 15)
    assert (kept.sync_delay_us, kept.sync_width_us) == (15, 30)
    with pytest.raises(PlanError, match="at most 20 us"):
        dmd.load(sequence(3), SLOW.model_copy(update={"sync_delay_us": 21}))


def test_a_start_begins_with_the_first_picture_and_a_wait_ends_with_the_boards_word() -> None:
    board = Board()
    dmd = opened(board)
    dmd.load(sequence(3), SLOW)
    board.sent.clear()
    dmd.start()
    assert board.of(0x1A24) == [b"\x00", b"\x02"]
    board.answers[0x1A0C] = b"\x02"
    with pytest.raises(DeviceTimeout, match="4 of 4 pictures shown"):
        dmd.wait(0.1)
    with pytest.raises(WrongState):
        dmd.start()
    board.answers[0x1A0C] = b"\x00"
    dmd.wait(0.1)


def test_a_sequencer_that_broke_off_is_told() -> None:
    board = Board()
    dmd = opened(board)
    dmd.load(sequence(3), SLOW)
    dmd.start()
    board.answers[0x1A0A] = b"\x41"
    with pytest.raises(DeviceError, match="sequencer abort"):
        dmd.wait(1.0)


def test_an_error_is_told_in_words_with_its_code() -> None:
    board = Board()
    dmd = opened(board)
    board.fails[0x1A34] = 14
    with pytest.raises(DeviceRefused, match="0x1A34 refused: exposure out of range") as refused:
        dmd.load(sequence(3), SLOW)
    assert refused.value.code == "14"
    with pytest.raises(WrongState):
        dmd.start()


def test_an_image_that_was_not_taken_is_told_after_its_data() -> None:
    board = Board()
    dmd = opened(board)
    board.answers[0x0100] = b"\x08"
    with pytest.raises(DeviceRefused, match="image 0 refused: out of memory"):
        dmd.load(sequence(3), SLOW)


def test_a_reply_with_another_number_is_passed_over() -> None:
    board = Board()
    dmd = opened(board)
    board.stale = struct.pack("<BBH", 0xC0, 250, 1) + b"\x02" + bytes(59)
    assert not dmd.running


def test_silence_is_a_timeout_that_names_the_command() -> None:
    board = Board()
    dmd = opened(board)
    board.mute = True
    with pytest.raises(DeviceTimeout, match="0x1A0C"):
        _ = dmd.running


def test_a_board_that_is_gone_is_disconnected_and_closed_all_the_same() -> None:
    board = Board()
    dmd = opened(board)
    board.gone = True
    with pytest.raises(DeviceDisconnected):
        dmd.__exit__(None, None, None)
    assert board.closed
    dmd.__exit__(None, None, None)
    assert not dmd.running


@pytest.mark.parametrize(
    ("command", "answer", "error", "says"),
    [
        (0x0206, b"\x03" + b"DLP670S".ljust(31, b"\0"), DriverUnavailable, "hardware 3 \\(DLP670S\\)"),
        (0x0206, b"\x02" + b"DLP9000".ljust(31, b"\0"), DeviceError, "second controller is missing"),
        (0x1A0A, b"\x00", DeviceError, "start has failed"),
        (0x1A0A, b"\x03", DeviceError, "do not fit"),
        (0x1A0B, b"\x00", DeviceError, "memory has failed"),
    ],
)
def test_a_board_that_is_not_well_is_refused(command: int, answer: bytes, error: type[DeviceError], says: str) -> None:
    board = Board()
    board.answers[command] = answer
    with pytest.raises(error, match=says):
        opened(board)
    assert board.closed


def test_a_transport_of_another_kind_is_refused() -> None:
    with pytest.raises(InputError, match="HID"):
        Dlpc900(Dlpc900Settings(), BenchContext(clock=Clock(), transport=object()))


def test_400_pictures_are_the_most() -> None:
    board = Board()
    dmd = opened(board)
    dmd.load(sequence(399), SLOW)
    assert board.of(0x1A31) == [struct.pack("<HI", 400, 1)]
    assert [struct.unpack("<H", data[:2])[0] for data in board.of(0x1A2A)] == list(range(16, -1, -1))
    with pytest.raises(PlanError, match="at most 400"):
        dmd.load(sequence(400), SLOW)
