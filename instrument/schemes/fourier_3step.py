"""The six-pattern scheme of Zhang 2019, which only tracks: three binary Fourier patterns along x and three along y.

The coefficients are O~(f, 0) = (2 I_0 - I_120 - I_240) 2/3 + j (I_120 - I_240) 2/sqrt3 (what every frame sees, such as ambient
light, drops out), and O~(0, f) likewise. The three grey fringes of an axis add to 3/2 everywhere, so that 2/3 of the sum of
their values is the total light S; the mean of both axes is taken.

References:
    Z. Zhang, J. Ye, Q. Deng, J. Zhong, "Image-free real-time detection and tracking of fast moving object using a single-pixel
    detector", Opt. Express 27(24) (2019) 35394: three steps of phase along both axes, without an image.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from instrument.config import SchemePlugin
from instrument.plan import Plan
from instrument.schemes.columns import Column
from instrument.schemes.fringes import FringeSettings, fringe_patterns, stepped_columns
from instrument.schemes.hadamard_pairs import sequence_of
from instrument.schemes.reading import PositionReading, fourier_reading
from protocols import Bytes, Floats, PatternSequence

_STEPS = 3


class FourierThreeStepSettings(FringeSettings):
    """``[scheme]`` of three-step Fourier tracking."""

    patterns_per_frame: ClassVar[int] = 2 * _STEPS

    name: str = "fourier-3step"
    """The scheme."""


@dataclass(frozen=True)
class FourierThreeStep:
    """Patterns and their meaning for one plan: x fringe at 0, 2 pi/3 and 4 pi/3, then the y fringe likewise."""

    plan: Plan
    """The run that this scheme serves."""

    settings: FourierThreeStepSettings
    """The plan's ``[scheme]`` table."""

    name: ClassVar[str] = "fourier-3step"

    image_rows: ClassVar[None] = None
    """No pattern changes from frame to frame, so that there is no image."""

    @cached_property
    def columns(self) -> tuple[Column, ...]:
        """The six patterns."""
        return stepped_columns(_STEPS)

    @cached_property
    def light_weights(self) -> Floats:
        """S = 2/3 of the sum of an axis's three values, both axes averaged: 1/3 for each."""
        return np.full(2 * _STEPS, 1 / 3)

    @cached_property
    def position(self) -> PositionReading:
        """The Fourier coefficients' phases, of period 1 / f."""
        return fourier_reading(self.columns, self.plan.image_size / self.settings.fourier_cycles)

    @cached_property
    def fixed_patterns(self) -> Bytes:
        """``(6, samples, samples)`` of 0 and 1: all patterns, dithered."""
        return fringe_patterns(self.columns, self.plan.image_size, self.settings)

    def sequence(self, columns: int = 1024, rows: int = 768) -> PatternSequence:
        """Unique planes and play order, as ``sequence_of`` makes them.

        Raises:
            PlanError: the field does not fit on the mirrors.
        """
        return sequence_of(self.plan, self.fixed_patterns, None, columns=columns, rows=rows)


plugin = SchemePlugin(
    summary="six patterns: three Fourier steps along x and three along y (Zhang 2019); position only",
    settings=FourierThreeStepSettings,
    make=FourierThreeStep,
)
