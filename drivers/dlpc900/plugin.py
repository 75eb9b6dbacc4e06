"""Entry point ``kinopix.modulators``: ``dlpc900``."""

from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from typing import Any

from drivers.dlpc900.constants import PRODUCT_ID, VENDOR_ID
from drivers.dlpc900.driver import Dlpc900
from drivers.dlpc900.questions import QUESTIONS
from drivers.dlpc900.settings import Dlpc900Settings
from protocols import Availability, DriverPlugin


def availability() -> Availability:
    """Look for hidapi."""
    try:
        return Availability(ready=True, version=f"hidapi {version('hidapi')}")
    except PackageNotFoundError:
        return Availability(ready=False, missing="no hidapi. To do: pip install 'kinopix[dlpc900]'")


def probe() -> tuple[str, ...]:
    """Give one line for each DLPC900 on USB; none where hidapi is not installed."""
    try:
        hid: Any = import_module("hid")  # an optional extra
    except ImportError:
        return ()
    found = hid.enumerate(VENDOR_ID, PRODUCT_ID)
    return tuple(f"DLPC900, serial number {device['serial_number'] or 'not told'}" for device in found)


plugin = DriverPlugin(
    summary="TI DLPC900 (LightCrafter 6500, 9000) over USB-HID, patterns on the fly (hidapi)",
    settings=Dlpc900Settings,
    open=Dlpc900,
    availability=availability,
    probe=probe,
    questions=QUESTIONS,
)
