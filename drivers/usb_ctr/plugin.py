"""Plug-in ``usb-ctr``: an H10682 on a Measurement Computing USB-CTR04 or USB-CTR08.

The transport it takes instead of libusb is a ``usb1.USBContext``, or what behaves like one.
"""

from importlib.metadata import version

from drivers.h10682.counter import H10682Counter
from drivers.usb_ctr.board import UsbCtrBoard, open_loaded_board, typed_error
from drivers.usb_ctr.driver import usb_ctr_counter
from drivers.usb_ctr.image import maker_image
from drivers.usb_ctr.pipe import UsbFault, find_pipes
from drivers.usb_ctr.questions import QUESTIONS
from drivers.usb_ctr.self_test import SelfTest, self_test
from drivers.usb_ctr.settings import UsbCtrSettings
from protocols import Availability, BenchContext, DriverPlugin, KinopixError


def open_counter(settings: UsbCtrSettings, context: BenchContext) -> H10682Counter:
    """Open the board and load its FPGA where it has no image yet.

    Raises:
        DriverUnavailable: no libusb, no board, several boards, or no FPGA image.
        InputError: a counter or an image that does not exist, or a transport that is not made for USB.
    """
    board = open_loaded_board(settings, context)
    try:
        return usb_ctr_counter(settings, board, context.clock, simulated=context.transport is not None)
    except BaseException:
        board.close()
        raise


def run_self_test(settings: UsbCtrSettings, context: BenchContext | None = None, *, timer: int = 0) -> SelfTest:
    """Find the debounce code that counts and the bit that means "scan done", on a board that no counter holds.

    Args:
        settings: serial number, FPGA image and photon input, as in bench.toml.
        context: clock and folder; None takes the host's clock and the current folder.
        timer: number of the timer output (TMR) that is wired to the photon input for the test.

    Raises:
        DriverUnavailable: as ``open_counter``.
        DeviceTimeout: a paced scan of the board gives no samples.
    """
    context = context or BenchContext()
    board = open_loaded_board(settings, context)
    try:
        return self_test(board, context.clock, counter=settings.counter, timer=timer)
    finally:
        board.close()


def availability() -> Availability:
    """Look for libusb and for the maker's FPGA image, without touching a board."""
    try:
        find_pipes()
    except UsbFault as fault:
        error = typed_error(fault, "looking for boards")
        return Availability(ready=False, missing=f"{error.saw}. To do: {error.remedy}")
    if maker_image() is None:
        return Availability(
            ready=False,
            missing="libusb is there; the maker's FPGA image, which a board needs after each power-up, is not. To do: set"
            " fpga_image under [counter] in bench.toml to the maker's file (usb-ctr.rbf), or install mccdaq/uldaq (Linux)",
        )
    return Availability(ready=True, version=f"libusb1 {version('libusb1')}")


def probe() -> tuple[str, ...]:
    """Give one line for each board on the bus; one that cannot be opened is told with the reason."""
    try:
        pipes = find_pipes()
    except UsbFault:
        return ()
    lines: list[str] = []
    for pipe in pipes:
        try:
            board = UsbCtrBoard(pipe)
            lines.append(f"{board.model} {board.serial}")
            board.close()
        except KinopixError as error:
            lines.append(f"USB-CTR: {error}")
    return tuple(lines)


plugin: DriverPlugin[UsbCtrSettings, H10682Counter] = DriverPlugin(
    summary="H10682 photon counter on a Measurement Computing USB-CTR04/08 (libusb)",
    settings=UsbCtrSettings,
    open=open_counter,
    availability=availability,
    probe=probe,
    questions=QUESTIONS,
)
