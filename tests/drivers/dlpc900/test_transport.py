"""Reports through hidapi, on a library that keeps what it was given."""

import sys
from types import SimpleNamespace
from typing import Any

import pytest

from drivers.dlpc900.driver import Dlpc900
from drivers.dlpc900.plugin import availability, probe
from drivers.dlpc900.settings import Dlpc900Settings
from drivers.dlpc900.transport import HidApi
from protocols import BenchContext, DriverUnavailable


class Library:
    """As much of hidapi's ``device`` as is used."""

    def __init__(self) -> None:
        self.opened: list[Any] = []
        self.written: list[bytes] = []
        self.waited_ms: list[int] = []
        self.absent = self.closed = False
        self.taken = 65

    def open(self, vendor: int, product: int, serial_number: str | None) -> None:
        if self.absent:
            raise OSError("open failed")
        self.opened.append((vendor, product, serial_number))

    def write(self, data: bytes) -> int:
        self.written.append(data)
        return self.taken

    def read(self, length: int, timeout_ms: int) -> list[int]:
        self.waited_ms.append(timeout_ms)
        return [7] * length

    def error(self) -> str:
        return "no such device"

    def close(self) -> None:
        self.closed = True


@pytest.fixture
def library(monkeypatch: pytest.MonkeyPatch) -> Library:
    library = Library()
    found = [{"serial_number": "LCR1"}, {"serial_number": ""}]

    def enumerate_boards(vendor: int, product: int) -> list[dict[str, str]]:
        assert (vendor, product) == (0x0451, 0xC900)
        return found

    module = SimpleNamespace(device=lambda: library, enumerate=enumerate_boards)
    monkeypatch.setitem(sys.modules, "hid", module)
    return library


def test_a_report_has_number_0_in_front_and_64_bytes_behind(library: Library) -> None:
    reports = HidApi("", "dmd")
    reports.write(bytes(range(64)))
    assert library.written == [b"\x00" + bytes(range(64))]
    assert reports.read(0.25) == bytes([7] * 64)
    reports.read(0.0)
    assert library.waited_ms == [250, 1]  # 0 would wait for ever
    reports.close()
    assert library.closed
    assert library.opened == [(0x0451, 0xC900, None)]


def test_a_serial_number_chooses_the_board(library: Library) -> None:
    HidApi("LCR1", "dmd")
    assert library.opened[0][2] == "LCR1"


def test_a_report_that_is_not_taken_is_an_error_of_the_port(library: Library) -> None:
    library.taken = -1
    with pytest.raises(OSError, match="no such device"):
        HidApi("", "dmd").write(bytes(64))


def test_a_board_that_cannot_be_opened_is_unavailable(library: Library) -> None:
    library.absent = True
    with pytest.raises(DriverUnavailable, match="udev"):
        Dlpc900(Dlpc900Settings(), BenchContext())


def test_without_the_library_the_extra_is_named(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "hid", None)
    with pytest.raises(DriverUnavailable, match=r"kinopix\[dlpc900\]"):
        Dlpc900(Dlpc900Settings(), BenchContext())
    assert probe() == ()


@pytest.mark.usefixtures("library")
def test_boards_are_listed_by_their_serial_numbers() -> None:
    assert probe() == ("DLPC900, serial number LCR1", "DLPC900, serial number not told")
    assert availability().ready == (availability().version != "")
