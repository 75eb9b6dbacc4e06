"""The board as its manual page: its FPGA, and what each error of the bus means."""

import errno
from pathlib import Path

import pytest

from drivers.usb_ctr.board import UsbCtrBoard, typed_error
from drivers.usb_ctr.pipe import UsbFault
from protocols import (
    DeviceBusy,
    DeviceDisconnected,
    DeviceError,
    DeviceRefused,
    DeviceTimeout,
    DriverUnavailable,
    InputError,
    KinopixError,
    ProtocolViolation,
)
from tests.drivers.usb_ctr.script import OPEN, WELL, Line, ScriptedPipe

NO_FPGA: Line = ("40 0 0", b"\x00\x00")


def board(*script: Line) -> UsbCtrBoard:
    return UsbCtrBoard(ScriptedPipe([OPEN[0], *script]))


def test_a_configured_fpga_is_left_alone() -> None:
    board(WELL).ensure_fpga(None)


def test_the_image_is_sent_after_the_unlock_byte_and_the_status_asked_again(tmp_path: Path) -> None:
    image = tmp_path / "usb-ctr.rbf"
    image.write_bytes(bytes(65))
    loading: list[Line] = [
        ("50 0 0 ad", None),
        ("51 0 0 " + "00" * 64, None),
        ("51 0 0 00", None),
        ("51 0 0 0000", None),
    ]
    board(NO_FPGA, *loading, WELL).ensure_fpga(image)
    with pytest.raises(DeviceRefused, match="0x0200"):
        board(NO_FPGA, *loading, ("40 0 0", b"\x00\x02")).ensure_fpga(image)


def test_a_board_without_its_image_says_where_to_get_it() -> None:
    with pytest.raises(DriverUnavailable, match="fpga_image"):
        board(NO_FPGA).ensure_fpga(None)


def test_an_image_that_cannot_be_read_or_is_empty_is_a_wrong_input(tmp_path: Path) -> None:
    empty = tmp_path / "empty.rbf"
    empty.touch()
    for path, why in ((empty, "an empty file"), (tmp_path / "none.rbf", "No such file")):
        with pytest.raises(InputError, match=why):
            board(NO_FPGA).ensure_fpga(path)


def test_a_short_answer_is_a_protocol_violation() -> None:
    with pytest.raises(ProtocolViolation, match=r"1 bytes in answer to STATUS \(0x40\), 2 expected"):
        board(("40 0 0", b"\x00")).status()


@pytest.mark.parametrize(
    ("number", "kind"),
    [
        (errno.ENODEV, DeviceDisconnected),
        (errno.EIO, DeviceDisconnected),
        (errno.EACCES, DriverUnavailable),
        (errno.EBUSY, DeviceBusy),
        (errno.ENOTSUP, DriverUnavailable),
        (errno.EPIPE, DeviceRefused),
        (errno.ETIMEDOUT, DeviceTimeout),
        (None, DriverUnavailable),
        (errno.EOVERFLOW, DeviceError),
    ],
)
def test_each_usb_error_is_a_typed_error(number: int | None, kind: type[KinopixError]) -> None:
    assert type(typed_error(UsbFault("it failed", number), "STATUS")) is kind
