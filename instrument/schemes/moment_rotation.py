"""The six-pattern scheme for objects that turn: moments of first and second order, one Hadamard pattern and its complement.

With S = I_H+ + I_H- the ramps give the centroid, as in ``moment_hadamard``. The moments of second order are those about the
middle of the field (``patterns.saddle``): one pattern for the difference mu20 - mu02, as nothing else of both enters the angle,
and one for mu11. The angle of the object's long axis is 1/2 atan2(2 mu11, mu20 - mu02) (``turn``).

References:
    Xiao et al., Opt. Express 30(22) (2022) 40389: low-order moments and Hadamard patterns for an object that turns. Which
    patterns they show we could not read.
    M.-K. Hu, IRE Trans. Inf. Theory 8 (1962) 179: central moments, and the angle of the principal axis.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np
from pydantic import PositiveInt

from instrument.config import SchemePlugin
from instrument.patterns import moment_pattern, saddle_pattern
from instrument.plan import Plan
from instrument.schemes.columns import Column, in_play_order
from instrument.schemes.hadamard_pairs import DitheredSettings, HadamardSettings, hadamard_rows, pair_light, sequence_of
from instrument.schemes.reading import PositionReading, moment_reading
from instrument.schemes.scheme import ImageRows
from instrument.schemes.turn import TurnReading
from protocols import Bytes, Floats, PatternSequence


class MomentRotationSettings(HadamardSettings, DitheredSettings):
    """``[scheme]`` of the scheme for objects that turn."""

    patterns_per_frame: ClassVar[int] = 6

    name: str = "moment-rotation"
    """The scheme."""

    upsampling: PositiveInt = 2
    """Dithering samples a side of one image pixel. Must divide the plan's ``superpixel``."""

    shuffle_seed: int | None = 0
    """Shuffle the chosen Hadamard patterns in time by this seed, so that fine and coarse ones see every angle. None keeps the
    order."""


@dataclass(frozen=True)
class MomentRotation:
    """Patterns and their meaning for one plan: x ramp, y ramp, u^2 - v^2, u v, H+, H-."""

    plan: Plan
    """The run that this scheme serves."""

    settings: MomentRotationSettings
    """The plan's ``[scheme]`` table."""

    name: ClassVar[str] = "moment-rotation"

    @cached_property
    def columns(self) -> tuple[Column, ...]:
        """The six patterns."""
        return in_play_order(
            Column(role="moment", axis="x"),
            Column(role="moment", axis="y"),
            Column(role="moment"),
            Column(role="moment"),
            Column(role="hadamard"),
            Column(role="hadamard", sign=-1),
        )

    @cached_property
    def light_weights(self) -> Floats:
        """S = I_H+ + I_H-."""
        return pair_light(self.columns)

    @cached_property
    def position(self) -> PositionReading:
        """The centroid, which has no period, and the angle."""
        reading = moment_reading(self.columns, self.plan.image_size)
        return replace(reading, turn=TurnReading.of(self.plan.image_size, self.columns, squares=2, product=3))

    @cached_property
    def fixed_patterns(self) -> Bytes:
        """``(4, samples, samples)`` of 0 and 1: both ramps and both moments of second order, dithered."""
        size, finer = self.plan.image_size, self.settings.upsampling
        ramps = [moment_pattern(size, "x", finer), moment_pattern(size, "y", finer)]
        return np.stack([*ramps, saddle_pattern(size, "squares", finer), saddle_pattern(size, "product", finer)])

    @cached_property
    def image_rows(self) -> ImageRows:
        """The Hadamard pattern of each frame."""
        return hadamard_rows(self.plan, self.settings, self.columns)

    def sequence(self, columns: int = 1024, rows: int = 768) -> PatternSequence:
        """Unique planes and play order, as ``sequence_of`` makes them.

        Raises:
            PlanError: the field does not fit on the mirrors.
        """
        return sequence_of(self.plan, self.fixed_patterns, self.image_rows.pairs, columns=columns, rows=rows)


plugin = SchemePlugin(
    summary="six patterns: moments of first and second order, one Hadamard and its complement (Xiao 2022); angle too",
    settings=MomentRotationSettings,
    make=MomentRotation,
)
