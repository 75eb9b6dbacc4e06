"""A sequence on the board: its controls, its timing and its planes (dlp7000.md 3.5)."""

import ctypes
from dataclasses import dataclass, field

from sim_backends.wire.alp.codes import (
    BIN_NORMAL,
    BIN_UNINTERRUPTED,
    BINARY_BOTTOMUP,
    BINARY_TOPDOWN,
    FLUT_18BIT,
    FLUT_NONE,
    MSB_ALIGN,
    Seq,
    require,
)
from sim_backends.wire.alp.flut import FrameTable
from sim_backends.wire.alp.planes import Geometry, Plane
from sim_backends.wire.alp.settings import AlpEmulatorSettings
from sim_backends.wire.alp.timing import Asked, Mode, Timing


@dataclass
class Sequence:
    """What AlpSeqAlloc makes."""

    settings: AlpEmulatorSettings
    geometry: Geometry
    bit_planes: int
    pictures: int
    memory_at: int
    planes: list[Plane | None] = field(init=False)
    controls: dict[int, int] = field(init=False)
    mode: Mode = field(init=False)
    timing: Timing = field(init=False)

    def __post_init__(self) -> None:
        """Set the defaults of the sheet; the default timing is 30 Hz."""
        self.planes = [None] * (self.bit_planes * self.pictures)
        self.controls = {
            Seq.REPEAT: 1,
            Seq.FIRSTFRAME: 0,
            Seq.LASTFRAME: self.pictures - 1,
            Seq.BITNUM: self.bit_planes,
            Seq.BIN_MODE: BIN_NORMAL,
            Seq.PWM_MODE: 0,
            Seq.DATA_FORMAT: MSB_ALIGN,
            Seq.FLUT_MODE: FLUT_NONE,
            Seq.PUT_LOCK: 0,
            Seq.FLUT_ENTRIES9: 1,
            Seq.FLUT_OFFSET9: 0,
            Seq.DMD_LINES: self.geometry.rows << 16,
        }
        self.set_timing(Asked())

    @property
    def lines(self) -> tuple[int, int]:
        """First row and number of rows that are loaded."""
        value = self.controls[Seq.DMD_LINES]
        return value & 0xFFFF, value >> 16

    @property
    def asked_mode(self) -> Mode:
        """What the controls ask for. AlpSeqTiming makes it the mode in force."""
        return Mode(self.controls[Seq.BITNUM], self.controls[Seq.BIN_MODE], self.geometry.rows - self.lines[1])

    @property
    def units(self) -> int:
        """Units of AlpSeqPut: pictures, or bit planes in the packed formats (dlp7000.md 3.8)."""
        packed = self.controls[Seq.DATA_FORMAT] in (BINARY_TOPDOWN, BINARY_BOTTOMUP)
        return self.pictures * (self.bit_planes if packed else 1)

    def put_lines(self, offset: int, load: int, lines: tuple[int, int], data: int) -> int:
        """Overwrite some lines of ``load`` units from ``offset`` on with what stands at the address ``data``.

        Returns:
            Bytes of one line.
        """
        first, count = lines
        data_format = self.controls[Seq.DATA_FORMAT]
        line_bytes = self.geometry.unit_bytes(data_format) // self.geometry.rows
        planes_a_unit = len(self.planes) // self.units
        for unit in range(load):
            body = ctypes.string_at(data + unit * count * line_bytes, count * line_bytes)
            top, bottom = first, self.geometry.rows - first - count
            framed = bytes(top * line_bytes) + body + bytes(bottom * line_bytes)
            place = (offset + unit) * planes_a_unit
            for plane, new in enumerate(self.geometry.planes_of(framed, data_format, planes_a_unit)):
                rows = slice(first, first + count)
                if data_format == BINARY_BOTTOMUP:
                    rows = slice(self.geometry.rows - first - count, self.geometry.rows - first)
                self.planes[place + plane] = self.geometry.merged(self.planes[place + plane], new, rows)
        return line_bytes

    def set_timing(self, asked: Asked) -> None:
        """AlpSeqTiming: it also puts BITNUM and BIN_MODE in force, so it must come after them (dlp7000.md 3.9).

        Raises:
            Refused: a time that cannot be kept; nothing has changed.
        """
        mode = self.asked_mode
        self.timing = asked.accepted(mode, self.settings)
        self.mode = mode

    def control(self, kind: int, value: int, table: FrameTable) -> None:
        """AlpSeqControl. A running projection keeps what it started with.

        Raises:
            Refused: a control that is not known here, or a value out of range.
        """
        require(kind in self.controls and self._allowed(kind, value, table))
        self.controls[kind] = value

    def _allowed(self, kind: int, value: int, table: FrameTable) -> bool:
        now = self.controls
        first, count = value & 0xFFFF, value >> 16
        rules = {
            Seq.REPEAT: 1 <= value <= self.settings.max_repeat,
            Seq.FIRSTFRAME: 0 <= value <= now[Seq.LASTFRAME],
            Seq.LASTFRAME: now[Seq.FIRSTFRAME] <= value < self.pictures,
            Seq.BITNUM: 1 <= value <= self.bit_planes and (value == 1 or now[Seq.BIN_MODE] == BIN_NORMAL),
            Seq.BIN_MODE: value == BIN_NORMAL or (value == BIN_UNINTERRUPTED and now[Seq.BITNUM] == 1),
            Seq.PWM_MODE: value == 0,
            Seq.DATA_FORMAT: MSB_ALIGN <= value <= BINARY_BOTTOMUP,
            Seq.FLUT_MODE: FLUT_NONE <= value <= FLUT_18BIT and table.accepts(value),
            Seq.PUT_LOCK: True,
            Seq.FLUT_ENTRIES9: 1 <= value <= table.slots - now[Seq.FLUT_OFFSET9],
            Seq.FLUT_OFFSET9: value >= 0 and value % 256 == 0 and value + now[Seq.FLUT_ENTRIES9] <= table.slots,
            Seq.DMD_LINES: value > 0 and count >= 1 and first + count <= self.geometry.rows,
        }
        return rules[Seq(kind)]

    def inquire(self, kind: int) -> int:
        """AlpSeqInquire.

        Raises:
            Refused: an inquiry that is not known here.
        """
        timing, settings = self.timing, self.settings
        values = {
            **self.controls,
            Seq.BITPLANES: self.bit_planes,
            Seq.PICNUM: self.pictures,
            Seq.PICTURE_TIME: timing.picture_us,
            Seq.ILLUMINATE_TIME: timing.illuminate_us,
            Seq.SYNCH_DELAY: timing.synch_delay_us,
            Seq.SYNCH_PULSEWIDTH: timing.synch_pulse_us,
            Seq.TRIGGER_IN_DELAY: timing.trigger_in_delay_us,
            Seq.MAX_SYNCH_DELAY: settings.max_synch_delay_us,
            Seq.MAX_TRIGGER_IN_DELAY: settings.max_trigger_in_delay_us,
            Seq.MIN_PICTURE_TIME: self.asked_mode.min_picture_us(settings),
            Seq.MIN_ILLUMINATE_TIME: self.asked_mode.min_illuminate_us(settings),
            Seq.MAX_PICTURE_TIME: settings.max_picture_time_us,
            Seq.ON_TIME: timing.on_us(self.mode),
            Seq.OFF_TIME: timing.picture_us - timing.on_us(self.mode),
        }
        require(kind in values)
        return values[kind]
