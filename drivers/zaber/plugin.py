"""Entry point ``kinopix.stages``: ``zaber``."""

from drivers.serial_line import availability, probe
from drivers.zaber.driver import open_zaber
from drivers.zaber.questions import QUESTIONS
from drivers.zaber.settings import ZaberSettings
from protocols import DriverPlugin

plugin = DriverPlugin(
    summary="Zaber linear stage, by the ASCII protocol over a serial line",
    settings=ZaberSettings,
    open=open_zaber,
    availability=availability,
    probe=probe,
    questions=QUESTIONS,
)
