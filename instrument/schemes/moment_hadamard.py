"""The four-pattern scheme of Guo 2022: a moment pattern along x and one along y, one Hadamard pattern and its complement.

With S = I_H+ + I_H- and the ramps of ``patterns.ramp``, the object's centroid is m I_x / S - 1/2 px, and m I_y / S - 1/2 px.
It is unambiguous over the whole field. Noise weighs more than with Fourier patterns: a ramp over m pixels changes by 1 / m of
the light for a pixel of motion, a fringe of two periods by up to 2 pi / m.

References:
    Li, Cai, Wang, Yao, Zhao, "Single-pixel imaging of a translational object", Opt. Express (2023), called *the paper*: table 1,
    which compares with Guo et al. (2022); the pattern set is inferred from the frame rates that it states.
    Zha, Shi, Meng, Liu, Peng, Opt. Express 29(19) (2021) 30327: geometric moment patterns.
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
from instrument.schemes.hadamard_pairs import DitheredSettings, HadamardSettings, hadamard_rows, pair_light, sequence_of
from instrument.schemes.reading import PositionReading, moment_reading
from instrument.schemes.scheme import ImageRows
from protocols import Bytes, Floats, PatternSequence


class MomentHadamardSettings(HadamardSettings, DitheredSettings):
    """``[scheme]`` of the four-pattern scheme."""

    patterns_per_frame: ClassVar[int] = 4

    name: str = "moment-hadamard"
    """The scheme."""

    upsampling: PositiveInt = 2
    """Dithering samples a side of one image pixel. Must divide the plan's ``superpixel``. A ramp suffers more from dithering
    than a fringe does, so that 2 is usual."""


@dataclass(frozen=True)
class MomentHadamard:
    """Patterns and their meaning for one plan: x ramp, y ramp, H+, H-."""

    plan: Plan
    """The run that this scheme serves."""

    settings: MomentHadamardSettings
    """The plan's ``[scheme]`` table."""

    name: ClassVar[str] = "moment-hadamard"

    @cached_property
    def columns(self) -> tuple[Column, ...]:
        """The four patterns."""
        return in_play_order(
            Column(role="moment", axis="x"),
            Column(role="moment", axis="y"),
            Column(role="hadamard"),
            Column(role="hadamard", sign=-1),
        )

    @cached_property
    def light_weights(self) -> Floats:
        """S = I_H+ + I_H-."""
        return pair_light(self.columns)

    @cached_property
    def position(self) -> PositionReading:
        """The centroid, which has no period."""
        return moment_reading(self.columns, self.plan.image_size)

    @cached_property
    def fixed_patterns(self) -> Bytes:
        """``(2, samples, samples)`` of 0 and 1: the ramp along x and the one along y, dithered."""
        size, upsampling = self.plan.image_size, self.settings.upsampling
        return np.stack([moment_pattern(size, "x", upsampling), moment_pattern(size, "y", upsampling)])

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
    summary="four patterns: two moments, one Hadamard and its complement (Guo 2022); position and image",
    settings=MomentHadamardSettings,
    make=MomentHadamard,
)
