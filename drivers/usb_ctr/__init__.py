"""USB-CTR counter boards of Measurement Computing, over USB, reading an H10682 head (``drivers.h10682``)."""

from drivers.usb_ctr.plugin import run_self_test
from drivers.usb_ctr.settings import UsbCtrSettings

__all__ = ["UsbCtrSettings", "run_self_test"]
