"""The complementary moments of Zha 2022, which only track, for one detector: a ramp and its complement along each axis.

Zha et al. show two patterns, and measure each with two detectors, in the two directions into which mirrors turn the light: one
sees the ramp, the other its complement. x = I_1 / (I_1 + I_1'), in fields, and y = I_2 / (I_2 + I_2'). A bench of one detector
shows the complements as patterns of their own, in a second pass over each pair: four patterns a frame. A pattern and its
complement add to the all-on pattern, so that the total light S is the sum of an axis's two values; the mean of both axes is
taken.

References:
    Zha et al., Opt. Lett. 47(4) (2022) 870: 11.1 kHz at 22.2 kHz.
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


class MomentComplementarySettings(DitheredSettings):
    """``[scheme]`` of the complementary moments."""

    patterns_per_frame: ClassVar[int] = 4

    name: str = "moment-complementary"
    """The scheme."""

    upsampling: PositiveInt = 2
    """Dithering samples a side of one image pixel. Must divide the plan's ``superpixel``."""


@dataclass(frozen=True)
class ComplementaryMoments:
    """Patterns and their meaning for one plan: x ramp, its complement, y ramp, its complement."""

    plan: Plan
    """The run that this scheme serves."""

    settings: MomentComplementarySettings
    """The plan's ``[scheme]`` table."""

    name: ClassVar[str] = "moment-complementary"

    image_rows: ClassVar[None] = None
    """No pattern changes from frame to frame, so that there is no image."""

    @cached_property
    def columns(self) -> tuple[Column, ...]:
        """The four patterns."""
        return in_play_order(
            Column(role="moment", axis="x"),
            Column(role="moment", axis="x", sign=-1),
            Column(role="moment", axis="y"),
            Column(role="moment", axis="y", sign=-1),
        )

    @cached_property
    def light_weights(self) -> Floats:
        """S = I + I' of an axis, both axes averaged: 1/2 for each value."""
        return np.full(4, 1 / 2)

    @cached_property
    def position(self) -> PositionReading:
        """The centroid, which has no period."""
        return moment_reading(self.columns, self.plan.image_size)

    @cached_property
    def fixed_patterns(self) -> Bytes:
        """``(4, samples, samples)`` of 0 and 1: the ramp along x, dithered, and its complement, then likewise along y."""
        size, upsampling = self.plan.image_size, self.settings.upsampling
        x, y = moment_pattern(size, "x", upsampling), moment_pattern(size, "y", upsampling)
        return np.stack([x, 1 - x, y, 1 - y])

    def sequence(self, columns: int = 1024, rows: int = 768) -> PatternSequence:
        """Unique planes and play order, as ``sequence_of`` makes them.

        Raises:
            PlanError: the field does not fit on the mirrors.
        """
        return sequence_of(self.plan, self.fixed_patterns, None, columns=columns, rows=rows)


plugin = SchemePlugin(
    summary="four patterns: moments 10 and 01, each with its complement (Zha 2022, by one detector); position only",
    settings=MomentComplementarySettings,
    make=ComplementaryMoments,
)
