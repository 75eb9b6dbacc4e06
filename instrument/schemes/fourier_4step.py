"""Four-step Fourier tracking: four binary Fourier patterns along x and four along y, a quarter of a period apart.

The coefficients are O~(f, 0) = (I_0 - I_180) + j (I_90 - I_270), and O~(0, f) likewise. The patterns at 180 and 270 degrees are
the complements of those at 0 and 90, so that the four values of an axis add to 2 S exactly.

References:
    Li, Cai, Wang, Yao, Zhao, "Single-pixel imaging of a translational object", Opt. Express (2023), called *the paper*:
    equation 3, from which its own two values an axis follow.
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

_STEPS = 4


class FourierFourStepSettings(FringeSettings):
    """``[scheme]`` of four-step Fourier tracking."""

    patterns_per_frame: ClassVar[int] = 2 * _STEPS

    name: str = "fourier-4step"
    """The scheme."""


@dataclass(frozen=True)
class FourierFourStep:
    """Patterns and their meaning for one plan: x fringe at 0, pi/2, pi and 3 pi/2, then the y fringe likewise."""

    plan: Plan
    """The run that this scheme serves."""

    settings: FourierFourStepSettings
    """The plan's ``[scheme]`` table."""

    name: ClassVar[str] = "fourier-4step"

    image_rows: ClassVar[None] = None
    """No pattern changes from frame to frame, so that there is no image."""

    @cached_property
    def columns(self) -> tuple[Column, ...]:
        """The eight patterns."""
        return stepped_columns(_STEPS)

    @cached_property
    def light_weights(self) -> Floats:
        """S = half of the sum of an axis's four values, both axes averaged: 1/4 for each."""
        return np.full(2 * _STEPS, 1 / 4)

    @cached_property
    def position(self) -> PositionReading:
        """The Fourier coefficients' phases, of period 1 / f."""
        return fourier_reading(self.columns, self.plan.image_size / self.settings.fourier_cycles)

    @cached_property
    def fixed_patterns(self) -> Bytes:
        """``(8, samples, samples)`` of 0 and 1: all patterns, dithered, the last two of an axis complements of its first two."""
        first = [column for column in self.columns if column.phase_rad < np.pi]
        x0, x90, y0, y90 = fringe_patterns(first, self.plan.image_size, self.settings)
        return np.stack([x0, x90, 1 - x0, 1 - x90, y0, y90, 1 - y0, 1 - y90])

    def sequence(self, columns: int = 1024, rows: int = 768) -> PatternSequence:
        """Unique planes and play order, as ``sequence_of`` makes them.

        Raises:
            PlanError: the field does not fit on the mirrors.
        """
        return sequence_of(self.plan, self.fixed_patterns, None, columns=columns, rows=rows)


plugin = SchemePlugin(
    summary="eight patterns: four Fourier steps along x and four along y (Li 2023, equation 3); position only",
    settings=FourierFourStepSettings,
    make=FourierFourStep,
)
