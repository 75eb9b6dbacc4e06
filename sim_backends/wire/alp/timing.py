"""The timing rules of dlp7000.md 3.10: what AlpSeqTiming accepts, and what it fills in."""

import math
from dataclasses import dataclass

from sim_backends.wire.alp.codes import BIN_UNINTERRUPTED, require
from sim_backends.wire.alp.settings import AlpEmulatorSettings


@dataclass(frozen=True)
class Mode:
    """What the shortest times depend on."""

    bits: int
    """Setting of ALP_BITNUM."""

    bin_mode: int
    """Setting of ALP_BIN_MODE: ALP_BIN_NORMAL or ALP_BIN_UNINTERRUPTED."""

    rows_left_out: int
    """Number of rows outside ALP_SEQ_DMD_LINES."""

    @property
    def uninterrupted(self) -> bool:
        """Whether a picture stays until the next one."""
        return self.bin_mode == BIN_UNINTERRUPTED

    def min_illuminate_us(self, settings: AlpEmulatorSettings) -> int:
        """Shortest illuminate time: one array load a bit plane, each twice as long as the one before [I]."""
        plane_us = math.ceil(settings.min_picture_time_us - settings.row_load_us * self.rows_left_out)
        return plane_us * ((1 << self.bits) - 1)

    def dark_us(self, settings: AlpEmulatorSettings) -> int:
        """Shortest dark phase."""
        return 0 if self.uninterrupted else settings.min_dark_us

    def min_picture_us(self, settings: AlpEmulatorSettings) -> int:
        """Shortest picture time."""
        return self.min_illuminate_us(settings) + self.dark_us(settings)


@dataclass(frozen=True)
class Timing:
    """What AlpSeqTiming left on the board, all in microseconds."""

    illuminate_us: int
    picture_us: int
    synch_delay_us: int
    synch_pulse_us: int
    trigger_in_delay_us: int

    def on_us(self, mode: Mode) -> int:
        """ALP_ON_TIME."""
        return self.picture_us if mode.uninterrupted else self.illuminate_us


@dataclass(frozen=True)
class Asked:
    """The five arguments of AlpSeqTiming in microseconds; 0 is ALP_DEFAULT."""

    illuminate_us: int = 0
    picture_us: int = 0
    synch_delay_us: int = 0
    synch_pulse_us: int = 0
    trigger_in_delay_us: int = 0

    def accepted(self, mode: Mode, settings: AlpEmulatorSettings) -> Timing:
        """Fill in the defaults.

        Raises:
            Refused: a time that cannot be kept, with ``timing_violation_code``.
        """
        dark_us = mode.dark_us(settings)
        picture_us = self.picture_us
        # Uninterrupted, an illuminate time longer than the picture is no error: it is ignored.
        ignored = mode.uninterrupted and 0 < picture_us < self.illuminate_us
        asked_us = 0 if ignored else self.illuminate_us
        if picture_us == 0:
            picture_us = asked_us + dark_us if asked_us else settings.default_picture_time_us
        illuminate_us = asked_us or max(mode.min_illuminate_us(settings), picture_us - settings.min_dark_us)
        default_pulse_us = illuminate_us + (0 if mode.uninterrupted else self.synch_delay_us)
        times = (self.illuminate_us, self.picture_us, self.synch_delay_us, self.synch_pulse_us)
        rules = (
            min(*times, self.trigger_in_delay_us) >= 0,
            mode.min_picture_us(settings) <= picture_us <= settings.max_picture_time_us,
            illuminate_us + dark_us <= picture_us,
            self.synch_delay_us <= settings.max_synch_delay_us,
            self.trigger_in_delay_us <= settings.max_trigger_in_delay_us,
            # Only a width that was asked for is refused; the default of normal mode may well be longer (3.10).
            self.synch_pulse_us < picture_us,
        )
        require(all(rules), settings.timing_violation_code)
        pulse_us = self.synch_pulse_us or default_pulse_us
        return Timing(illuminate_us, picture_us, self.synch_delay_us, pulse_us, self.trigger_in_delay_us)
