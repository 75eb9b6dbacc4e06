"""Entry point of the emulated USB-CTR: ``transport = "usb-ctr-emulator"`` under ``[counter]``."""

from protocols import BenchContext, TransportPlugin
from sim_backends.wire.seen_edges import photon_bench_of
from sim_backends.wire.usb_ctr.board import EmulatedUsbCtrBoard
from sim_backends.wire.usb_ctr.context import UsbCtrContext
from sim_backends.wire.usb_ctr.settings import UsbCtrEmulatorSettings

_NAME = "usb-ctr-emulator"


def open_emulator(settings: UsbCtrEmulatorSettings, context: BenchContext) -> UsbCtrContext:
    """Plug an emulated device in.

    Returns:
        What behaves like a ``usb1.USBContext``.

    Raises:
        InputError: no optical bench, or one that does not count photons.
    """
    return UsbCtrContext(EmulatedUsbCtrBoard(settings, photon_bench_of(context, _NAME)))


plugin = TransportPlugin(
    summary="emulated MCC USB-CTR04/08 as libusb shows one (usb1)", settings=UsbCtrEmulatorSettings, open=open_emulator
)
"""Found as ``kinopix.transports: usb-ctr-emulator``."""
