"""The board behind the library: geometry by DMD type, and the device controls of dlp7000.md 3.4."""

from sim_backends.wire.alp.codes import (
    DMD_DISCONNECTED,
    EDGE_FALLING,
    EDGE_RISING,
    LEVEL_HIGH,
    LEVEL_LOW,
    Dev,
    State,
    require,
)
from sim_backends.wire.alp.memory import FrameMemory
from sim_backends.wire.alp.planes import Geometry
from sim_backends.wire.alp.settings import AlpEmulatorSettings, NoDmd

_ARRAYS = {
    **dict.fromkeys((1, 4, 5, 6), (1024, 768)),
    2: (1400, 1050),
    **dict.fromkeys((3, 10, 11, DMD_DISCONNECTED), (1920, 1080)),
    7: (1920, 1200),
    **dict.fromkeys((8, 9), (2560, 1600)),
    12: (1280, 800),
}
"""Columns and rows of each DMD type. A missing DMD behaves like 1080p [V]."""

_TEMPERATURE = 45 * 256
"""45 degC in 1/256 degC."""


class Device:
    """What AlpDevInquire and AlpDevControl see."""

    def __init__(self, settings: AlpEmulatorSettings) -> None:
        """Power up."""
        self._settings = settings
        missing = any(isinstance(fault, NoDmd) for fault in settings.faults)
        self.dmd_type = DMD_DISCONNECTED if missing else settings.dmd_type
        self.geometry = Geometry.of(*_ARRAYS.get(self.dmd_type, (1920, 1080)))
        self.memory = FrameMemory(settings.memory_frames)
        self.state = State.IDLE
        self.controls: dict[int, int] = {
            Dev.SYNCH_POLARITY: LEVEL_HIGH,
            Dev.TRIGGER_EDGE: EDGE_RISING,
            Dev.TRIGGER_TIME_OUT: 0,
            Dev.USB_CONNECTION: 0,
            Dev.USB_DISCONNECT_BEHAVIOUR: 2,
            Dev.GPIO5_PIN_MUX: 0,
            Dev.PWM_LEVEL: 0,
            Dev.DMD_MODE: 0,
        }

    def control(self, kind: int, value: int) -> None:
        """AlpDevControl; ALP_DEFAULT chooses the usual level or edge.

        Raises:
            Refused: a control that is not known here, or a value out of range.
        """
        rules = {
            Dev.SYNCH_POLARITY: value in (0, LEVEL_HIGH, LEVEL_LOW),
            Dev.TRIGGER_EDGE: value in (0, EDGE_FALLING, EDGE_RISING),
            Dev.TRIGGER_TIME_OUT: value in (0, 1),
            Dev.USB_CONNECTION: value == 0,
            Dev.USB_DISCONNECT_BEHAVIOUR: value in (0, 1, 2),
            Dev.GPIO5_PIN_MUX: value in (0, 1, 16, 17),
            Dev.PWM_LEVEL: 0 <= value <= 100,
            Dev.DMD_MODE: value in (0, 1),
        }
        require(kind in self.controls and rules[Dev(kind)])
        usual = {Dev.SYNCH_POLARITY: LEVEL_HIGH, Dev.TRIGGER_EDGE: EDGE_RISING, Dev.USB_DISCONNECT_BEHAVIOUR: 2}
        self.controls[kind] = value or usual.get(Dev(kind), 0)

    def inquire(self, kind: int, state: State) -> int:
        """AlpDevInquire.

        Raises:
            Refused: an inquiry that is not known here.
        """
        values = {
            **self.controls,
            Dev.NUMBER: self._settings.serial_number,
            Dev.VERSION: self._settings.version,
            Dev.STATE: state,
            Dev.AVAIL_MEMORY: self.memory.largest_gap,
            Dev.DMDTYPE: self.dmd_type,
            Dev.DDC_FPGA_TEMPERATURE: _TEMPERATURE,
            Dev.APPS_FPGA_TEMPERATURE: _TEMPERATURE,
            Dev.PCB_TEMPERATURE: _TEMPERATURE,
            Dev.DISPLAY_HEIGHT: self.geometry.rows,
            Dev.DISPLAY_WIDTH: self.geometry.columns,
        }
        require(kind in values)
        return int(values[kind])
