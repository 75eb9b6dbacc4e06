"""The six-pattern scheme: four binary Fourier patterns, one Hadamard pattern and its complement in each frame.

With S = I_H+ + I_H-, the coefficients are O~(f, 0) = (2 I_x0 - S) + j (2 I_x90 - S), and O~(0, f) likewise.

References:
    Li, Cai, Wang, Yao, Zhao, "Single-pixel imaging of a translational object", Opt. Express (2023), called *the paper*:
    figure 1 and equations 8 and 9.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from instrument.config import SchemePlugin
from instrument.plan import Plan
from instrument.schemes.columns import Column, in_play_order
from instrument.schemes.fringes import FringeSettings, fringe_patterns
from instrument.schemes.hadamard_pairs import HadamardSettings, hadamard_rows, pair_light, sequence_of
from instrument.schemes.reading import PositionReading, fourier_reading
from instrument.schemes.scheme import ImageRows
from protocols import Bytes, Floats, PatternSequence

_QUARTER = np.pi / 2


class FourierHadamardSettings(HadamardSettings, FringeSettings):
    """``[scheme]`` of the six-pattern scheme."""

    patterns_per_frame: ClassVar[int] = 6

    name: str = "fourier-hadamard"
    """The scheme."""


@dataclass(frozen=True)
class FourierHadamard:
    """Patterns and their meaning for one plan: x fringe at 0 and pi/2, y fringe at 0 and pi/2, H+, H-."""

    plan: Plan
    """The run that this scheme serves."""

    settings: FourierHadamardSettings
    """The plan's ``[scheme]`` table."""

    name: ClassVar[str] = "fourier-hadamard"

    @cached_property
    def columns(self) -> tuple[Column, ...]:
        """The six patterns."""
        return in_play_order(
            Column(role="fourier", axis="x"),
            Column(role="fourier", axis="x", phase_rad=_QUARTER),
            Column(role="fourier", axis="y"),
            Column(role="fourier", axis="y", phase_rad=_QUARTER),
            Column(role="hadamard"),
            Column(role="hadamard", sign=-1),
        )

    @cached_property
    def light_weights(self) -> Floats:
        """S = I_H+ + I_H-."""
        return pair_light(self.columns)

    @cached_property
    def position(self) -> PositionReading:
        """The Fourier coefficients' phases, of period 1 / f."""
        return fourier_reading(self.columns, self.plan.image_size / self.settings.fourier_cycles)

    @cached_property
    def fixed_patterns(self) -> Bytes:
        """``(4, samples, samples)`` of 0 and 1: P(f,0,0), P(f,0,pi/2), P(0,f,0), P(0,f,pi/2), dithered."""
        return fringe_patterns(self.columns, self.plan.image_size, self.settings)

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
    summary="six patterns: four Fourier, one Hadamard and its complement (Li 2023); position and image",
    settings=FourierHadamardSettings,
    make=FourierHadamard,
)
