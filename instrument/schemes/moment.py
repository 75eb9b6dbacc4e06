"""The three-pattern scheme of Zha 2021, which only tracks: geometric moments of order 00, 10 and 01.

The moment of order 00 is the value of an all-on pattern, and so the total light S = m00. With the ramps of ``patterns.ramp``,
the object's centroid is m I_10 / S - 1/2 px along x and m I_01 / S - 1/2 px along y: m10 / m00 and m01 / m00.

References:
    Zha, Shi, Meng, Liu, Peng, Opt. Express 29(19) (2021) 30327: geometric moment patterns; 7.4 kHz at 22.2 kHz.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np
from pydantic import PositiveInt

from instrument.config import SchemePlugin
from instrument.patterns import moment_pattern
from instrument.plan import Plan
from instrument.schemes.columns import Column, in_play_order
from instrument.schemes.hadamard_pairs import DitheredSettings, sequence_of
from instrument.schemes.reading import PositionReading, moment_reading
from protocols import Bytes, Floats, PatternSequence


class MomentSettings(DitheredSettings):
    """``[scheme]`` of the three moments."""

    patterns_per_frame: ClassVar[int] = 3

    name: str = "moment"
    """The scheme."""

    upsampling: PositiveInt = 2
    """Dithering samples a side of one image pixel. Must divide the plan's ``superpixel``."""


@dataclass(frozen=True)
class Moments:
    """Patterns and their meaning for one plan: all on, x ramp, y ramp."""

    plan: Plan
    """The run that this scheme serves."""

    settings: MomentSettings
    """The plan's ``[scheme]`` table."""

    name: ClassVar[str] = "moment"

    image_rows: ClassVar[None] = None
    """No pattern changes from frame to frame, so that there is no image."""

    @cached_property
    def columns(self) -> tuple[Column, ...]:
        """The three patterns."""
        return in_play_order(Column(role="moment"), Column(role="moment", axis="x"), Column(role="moment", axis="y"))

    @cached_property
    def light_weights(self) -> Floats:
        """S is the value of the all-on pattern."""
        return np.array([1.0, 0.0, 0.0])

    @cached_property
    def position(self) -> PositionReading:
        """The centroid, which has no period."""
        return moment_reading(self.columns, self.plan.image_size)

    @cached_property
    def fixed_patterns(self) -> Bytes:
        """``(3, samples, samples)`` of 0 and 1: all on, then the ramp along x and the one along y, dithered."""
        size, upsampling = self.plan.image_size, self.settings.upsampling
        x, y = moment_pattern(size, "x", upsampling), moment_pattern(size, "y", upsampling)
        return np.stack([np.ones_like(x), x, y])

    def sequence(self, columns: int = 1024, rows: int = 768) -> PatternSequence:
        """Unique planes and play order, as ``sequence_of`` makes them.

        Raises:
            PlanError: the field does not fit on the mirrors.
        """
        return sequence_of(self.plan, self.fixed_patterns, None, columns=columns, rows=rows)


plugin = SchemePlugin(
    summary="three patterns: moments 00, 10 and 01 (Zha 2021); position only",
    settings=MomentSettings,
    make=Moments,
)
