"""Entry point ``kinopix.counters``: ``serial-counter``."""

from drivers.serial_counter.driver import open_serial_counter
from drivers.serial_counter.questions import QUESTIONS
from drivers.serial_counter.settings import SerialCounterSettings
from drivers.serial_line import availability, probe
from protocols import DriverPlugin

plugin = DriverPlugin(
    summary="photon counter that anybody can build, by a line protocol over a serial port",
    settings=SerialCounterSettings,
    open=open_serial_counter,
    availability=availability,
    probe=probe,
    questions=QUESTIONS,
)
