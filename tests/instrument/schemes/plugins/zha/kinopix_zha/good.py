"""Zha 2021's three moments with a Hadamard pair behind them: an all-on pattern, a ramp along x and one along y, H+, H-.

The total light is the value of the all-on pattern. With ``falling`` the ramps go from 1 to 0.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from instrument.patterns import moment_pattern
from instrument.plan import Plan
from instrument.schemes import (
    Column,
    DitheredSettings,
    HadamardSettings,
    ImageRows,
    PositionReading,
    SchemePlugin,
    hadamard_rows,
    in_play_order,
    moment_reading,
    sequence_of,
)
from protocols import Bytes, Floats, PatternSequence


class ZhaSettings(HadamardSettings, DitheredSettings):
    """Keys of ``[scheme]``."""

    patterns_per_frame: ClassVar[int] = 5

    name: str = "zha-moments"
    """The scheme."""

    falling: bool = False
    """Whether the ramps fall instead of rise."""


@dataclass(frozen=True)
class ZhaMoments:
    """The scheme for one plan."""

    plan: Plan
    settings: ZhaSettings
    name: ClassVar[str] = "zha-moments"

    @cached_property
    def columns(self) -> tuple[Column, ...]:
        """The five patterns."""
        return in_play_order(
            Column(role="moment"),
            Column(role="moment", axis="x"),
            Column(role="moment", axis="y"),
            Column(role="hadamard"),
            Column(role="hadamard", sign=-1),
        )

    @property
    def light_weights(self) -> Floats:
        """S is the value of the all-on pattern."""
        return np.array([1.0, 0, 0, 0, 0])

    @cached_property
    def position(self) -> PositionReading:
        """The centroid; a falling ramp sees what a rising one leaves."""
        rising = moment_reading(self.columns, self.plan.image_size)
        if not self.settings.falling:
            return rising
        return PositionReading(rising.columns, 1 - rising.base, -rising.response, rising.after_middle_frames, None)

    @cached_property
    def fixed_patterns(self) -> Bytes:
        """All-on, x ramp, y ramp."""
        size, finer = self.plan.image_size, self.settings.upsampling
        ramps = np.stack([moment_pattern(size, "x", finer), moment_pattern(size, "y", finer)])
        return np.concatenate([np.ones_like(ramps[:1]), 1 - ramps if self.settings.falling else ramps])

    @cached_property
    def image_rows(self) -> ImageRows:
        """H+ and H-."""
        return hadamard_rows(self.plan, self.settings, self.columns)

    def sequence(self, columns: int = 1024, rows: int = 768) -> PatternSequence:
        """Frames in play order."""
        return sequence_of(self.plan, self.fixed_patterns, self.image_rows.pairs, columns=columns, rows=rows)


plugin = SchemePlugin("Moments of Zha 2021, with an image", ZhaSettings, ZhaMoments)
