"""A USB-CTR board that is open: requests sent, answers checked, the FPGA loaded, scans started and stopped."""

import errno
from collections.abc import Callable
from pathlib import Path
from typing import TypeVar

from drivers.h10682.detector import NAME
from drivers.usb_ctr import codec
from drivers.usb_ctr.codec import BadAnswer, Request, Scan, Status
from drivers.usb_ctr.image import maker_image
from drivers.usb_ctr.pipe import UsbFault, UsbPipe, find_pipes
from drivers.usb_ctr.settings import UsbCtrSettings
from protocols import (
    BenchContext,
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

DoneT = TypeVar("DoneT")


def typed_error(fault: UsbFault, what: str) -> KinopixError:
    """Say what a USB failure means here, for the caller to raise or to keep."""
    saw = f"{fault.text} ({'' if fault.errno is None else errno.errorcode.get(fault.errno, fault.errno)}) at {what}"
    match fault.errno:
        case errno.ENODEV | errno.EIO | errno.ENOENT | errno.ENXIO | errno.ESHUTDOWN | errno.EPROTO:
            return DeviceDisconnected(
                device=NAME, saw=saw, expected="a board that answers", remedy="look at the USB cable, then open again"
            )
        case errno.ENOTSUP:
            return DriverUnavailable(
                device=NAME,
                saw=f"{saw}: the maker's driver holds the board, not libusb's",
                expected="a board on the WinUSB driver (Windows), with no other driver on it",
                remedy="on Windows, give the board WinUSB by Zadig (Options, List All Devices, USB-CTR, WinUSB, Replace Driver); "
                "the maker's InstaCal finds it again once that driver is removed in the Device Manager",
            )
        case errno.EACCES | errno.EPERM:
            return DriverUnavailable(
                device=NAME,
                saw=saw,
                expected="the right to use the board",
                remedy=f"on Linux, add a udev rule for vendor {codec.VENDOR_ID:04x} and plug the board in again",
            )
        case errno.EBUSY:
            return DeviceBusy(
                device=NAME, saw=saw, expected="a free board", remedy="close the other program that uses the board"
            )
        case errno.EPIPE:
            return DeviceRefused(
                NAME, code="stall", saw=saw, expected="a request that the board takes",
                remedy="unplug the board, plug it in and try again; report this if it comes back",
            )  # fmt: skip
        case errno.ETIMEDOUT:
            return DeviceTimeout(
                NAME, awaited=what, waited_s=1.0, progress="no answer", remedy="unplug the board and plug it in again"
            )
        case None:
            return DriverUnavailable(
                device=NAME, saw=fault.text, expected="libusb 1.0", remedy="install libusb 1.0 (Debian: libusb-1.0-0)"
            )
        case _:
            return DeviceError(device=NAME, saw=saw, expected="a transfer that succeeds", remedy="open the bench again")


class UsbCtrBoard:
    """Talks to one board. Raises the errors of ``typed_error`` and, for a wrong answer, ``ProtocolViolation``."""

    def __init__(self, pipe: UsbPipe) -> None:
        """Take over an open pipe and ask for the serial number."""
        self._pipe = pipe
        self.model = codec.PRODUCTS.get(pipe.product_id, f"product {pipe.product_id:#06x}")
        self.n_counters = 4 if self.model == "USB-CTR04" else 8
        try:
            self.serial = codec.parse_serial(self.ask(codec.ASK_SERIAL))
        except BadAnswer as error:
            raise _violation(str(error)) from error

    def ask(self, request: Request) -> bytes:
        """Send a request and give the answer, empty for one that has none."""
        what = f"{request.command.name} ({request.command:#04x})"
        try:
            if not request.reply_bytes:
                self._pipe.tell(request.command, request.value, request.index, request.data)
                return b""
            answer = self._pipe.ask(request.command, request.value, request.index, request.reply_bytes)
        except UsbFault as fault:
            raise typed_error(fault, what) from fault
        if len(answer) != request.reply_bytes:
            raise _violation(f"{len(answer)} bytes in answer to {what}, {request.reply_bytes} expected")
        return answer

    def status(self) -> Status:
        """The status bits now."""
        return codec.parse_status(self.ask(codec.ASK_STATUS))

    def fpga_version(self) -> str:
        """Version of the FPGA image, such as ``01.02``."""
        return codec.parse_fpga_version(self.ask(codec.ASK_FPGA_VERSION))

    def ensure_fpga(self, image: Path | None) -> None:
        """Load the FPGA image where the board has none: after each power-up.

        Raises:
            DriverUnavailable: it has none and no image is named.
            InputError: the file cannot be read or is empty.
            DeviceRefused: the board does not accept the image.
        """
        if self.status().fpga_configured:
            return
        if image is None:
            raise DriverUnavailable(
                device=NAME,
                saw="a board without its FPGA image",
                expected="status bit 8 set",
                remedy="set fpga_image in bench.toml to the maker's file (usb-ctr.rbf, part of Measurement Computing's software)",
            )
        for request in codec.load_fpga(_read_image(image)):
            self.ask(request)
        status = self.status()
        if not status.fpga_configured:
            raise DeviceRefused(
                NAME, code=f"status {status.bits:#06x}", saw=f"an FPGA that is not configured after {image.name}",
                expected="status bit 8 set", remedy="use the image that belongs to this board; unplug and try again",
            )  # fmt: skip

    def claim(self) -> None:
        """Take the board for this program.

        Raises:
            DeviceBusy: another program has it.
        """
        self._pipe_does(self._pipe.claim, "claiming the board")

    def start_scan(self, scan: Scan, *, samples: int = 0, pacer_period: int = 0, packet_words: int = 0) -> None:
        """Start in the order of the maker's library; a scan that somebody left running is stopped first."""
        self.ask(codec.STOP_SCAN)
        self.ask(codec.scan_config(scan))
        self.clear_halt()
        self.ask(codec.CLEAR_FIFO)
        self._pipe_does(self._pipe.begin_packets, "queueing transfers")
        self.ask(codec.scan_start(scan, samples=samples, pacer_period=pacer_period, packet_words=packet_words))

    def stop_scan(self) -> None:
        """Stop, and empty the board's memory and the pipe."""
        self.ask(codec.STOP_SCAN)
        self._pipe_does(self._pipe.end_packets, "cancelling transfers")
        self.ask(codec.CLEAR_FIFO)
        self.ask(codec.flush_bulk())

    def packet(self) -> bytes:
        """The next packet of scan data that has come; empty where none has."""
        return self._pipe_does(self._pipe.packet, "reading scan data")

    def clear_halt(self) -> None:
        """Clear a halt of the scan endpoint."""
        self._pipe_does(self._pipe.clear_halt, "clearing the scan endpoint")

    def close(self) -> None:
        """Give the board back. Never raises: it is gone or it is free."""
        try:
            self._pipe.close()
        except UsbFault:
            return

    def _pipe_does(self, action: Callable[[], DoneT], what: str) -> DoneT:
        try:
            return action()
        except UsbFault as fault:
            raise typed_error(fault, what) from fault


def open_board(transport: object | None, serial: str | None) -> UsbCtrBoard:
    """The board with this serial number, or the only one there is.

    Raises:
        DriverUnavailable: none, or several and no serial number to choose by.
        DeviceBusy: another program has it.
    """
    try:
        pipes = find_pipes(transport)
    except UsbFault as fault:
        raise typed_error(fault, "looking for boards") from fault
    boards: list[UsbCtrBoard] = []
    try:
        for pipe in pipes:
            boards.append(UsbCtrBoard(pipe))  # noqa: PERF401 - what is open must be closed if the next one fails
        chosen = [board for board in boards if serial in (None, board.serial)]
        if len(chosen) != 1:
            raise DriverUnavailable(
                device=NAME,
                saw="boards " + (", ".join(f"{board.model} {board.serial}" for board in boards) or "none"),
                expected="one USB-CTR04 or USB-CTR08" + (f" with serial number {serial}" if serial else ""),
                remedy="set serial in bench.toml" if chosen else "look at the USB cable and at serial in bench.toml",
            )
        chosen[0].claim()
    except BaseException:
        for board in boards:
            board.close()
        raise
    for board in boards:
        if board is not chosen[0]:
            board.close()
    return chosen[0]


def open_loaded_board(settings: UsbCtrSettings, context: BenchContext) -> UsbCtrBoard:
    """The board that the settings name, with its FPGA image.

    Raises:
        KinopixError: as ``open_board`` and ``UsbCtrBoard.ensure_fpga``.
    """
    board = open_board(context.transport, settings.serial)
    try:
        named = settings.fpga_image
        board.ensure_fpga(maker_image() if named is None else context.folder / named)
    except BaseException:
        board.close()
        raise
    return board


def _read_image(path: Path) -> bytes:
    try:
        image = path.read_bytes()
    except OSError as error:
        image, why = b"", str(error.strerror)
    else:
        why = "an empty file"
    if not image:
        raise InputError(
            device=NAME,
            saw=f"fpga_image {path}: {why}",
            expected="the maker's FPGA image",
            remedy="correct fpga_image in bench.toml",
        )
    return image


def _violation(saw: str) -> ProtocolViolation:
    return ProtocolViolation(
        device=NAME,
        saw=saw,
        expected="what the USB-CTR protocol allows",
        remedy="unplug the board and plug it in again",
    )
