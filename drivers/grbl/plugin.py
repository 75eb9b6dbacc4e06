"""Entry point ``kinopix.stages``: ``grbl``."""

from drivers.grbl.driver import open_grbl
from drivers.grbl.questions import QUESTIONS
from drivers.grbl.settings import GrblSettings
from drivers.serial_line import availability, probe
from protocols import DriverPlugin

plugin = DriverPlugin(
    summary="Linear stage on a GRBL 1.1 controller, over a serial line",
    settings=GrblSettings,
    open=open_grbl,
    availability=availability,
    probe=probe,
    questions=QUESTIONS,
)
