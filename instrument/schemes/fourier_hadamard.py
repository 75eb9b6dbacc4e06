"""The six-pattern scheme: four binary Fourier patterns, one Hadamard pattern and its complement in each frame.

With S = I_H+ + I_H-, the coefficients are O~(f, 0) = (2 I_x0 - S) + j (2 I_x90 - S), and O~(0, f) likewise. With
``moment_frames`` the first frames show ramps in the place of Hadamard patterns, for the absolute position (``ramps``).

References:
    Li, Cai, Wang, Yao, Zhao, "Single-pixel imaging of a translational object", Opt. Express (2023), called *the paper*:
    figure 1 and equations 8 and 9.
"""

from dataclasses import dataclass, replace
from functools import cached_property
from typing import ClassVar

import numpy as np
from pydantic import Field

from instrument.config import SchemePlugin
from instrument.plan import Plan
from instrument.schemes.columns import Column, in_play_order
from instrument.schemes.fringes import FringeSettings, fringe_patterns
from instrument.schemes.hadamard_pairs import HadamardSettings, hadamard_rows, pair_light, sequence_of
from instrument.schemes.ramps import Ramps
from instrument.schemes.reading import PositionReading, fourier_reading
from instrument.schemes.scheme import ImageRows
from protocols import Bytes, Floats, PatternSequence

_QUARTER = np.pi / 2


class FourierHadamardSettings(HadamardSettings, FringeSettings):
    """``[scheme]`` of the six-pattern scheme."""

    patterns_per_frame: ClassVar[int] = 6

    name: str = "fourier-hadamard"
    """The scheme."""

    moment_frames: int = Field(default=0, ge=0)
    """Frames at the start that show a ramp and its complement in the place of the Hadamard pair, along x and y in turn, for the
    absolute position; 0 for none. They are shown again after each image_size ** 2 frames."""

    def check(self, image_size: int, superpixel: int) -> None:
        """Refuse what dithered fringes do not allow, and more ramps than there are Hadamard patterns."""
        super().check(image_size, superpixel)
        if 2 * self.moment_frames > image_size**2:
            raise ValueError(
                f"scheme.moment_frames is {self.moment_frames}: at most half of the {image_size**2} Hadamard patterns"
            )


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
        reading = fourier_reading(self.columns, self.plan.image_size / self.settings.fourier_cycles)
        return replace(reading, ramps=self._ramps)

    @cached_property
    def fixed_patterns(self) -> Bytes:
        """``(4, samples, samples)`` of 0 and 1: P(f,0,0), P(f,0,pi/2), P(0,f,0), P(0,f,pi/2), dithered."""
        return fringe_patterns(self.columns, self.plan.image_size, self.settings)

    @cached_property
    def image_rows(self) -> ImageRows:
        """The Hadamard pattern of each frame."""
        return hadamard_rows(self.plan, self.settings, self.columns, self.settings.moment_frames)

    @property
    def _ramps(self) -> Ramps | None:
        """The ramps of the first frames, in the columns of H+ and H-."""
        size, settings = self.plan.image_size, self.settings
        frames = min(settings.moment_frames, self.plan.frames)
        return Ramps(size, settings.upsampling, frames, positive=4, negative=5) if frames else None

    def sequence(self, columns: int = 1024, rows: int = 768) -> PatternSequence:
        """Unique planes and play order, as ``sequence_of`` makes them.

        Raises:
            PlanError: the field does not fit on the mirrors.
        """
        ramps = None if self._ramps is None else self._ramps.patterns()
        return sequence_of(self.plan, self.fixed_patterns, self.image_rows.pairs, ramps, columns=columns, rows=rows)


plugin = SchemePlugin(
    summary="six patterns: four Fourier, one Hadamard and its complement (Li 2023); position and image",
    settings=FourierHadamardSettings,
    make=FourierHadamard,
)
