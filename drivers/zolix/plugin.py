"""Entry point ``kinopix.stages``: ``ka400z``."""

from drivers.serial_line import availability, probe
from drivers.zolix.driver import Ka400z
from drivers.zolix.questions import QUESTIONS
from drivers.zolix.settings import Ka400zSettings
from protocols import DriverPlugin

plugin = DriverPlugin(
    summary="Zolix KA400Z linear stage on an MC600 or SC300 controller, over a serial line",
    settings=Ka400zSettings,
    open=Ka400z,
    availability=availability,
    probe=probe,
    questions=QUESTIONS,
)
