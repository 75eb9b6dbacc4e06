"""Conventional differential Hadamard imaging of an object at rest: one Hadamard pattern and its complement in each frame.

A frame gives I_H = I_H+ - I_H-, one coefficient of the image's Hadamard transform, and the total light S = I_H+ + I_H-. No
pattern measures position.

References:
    Li, Cai, Wang, Yao, Zhao, "Single-pixel imaging of a translational object", Opt. Express (2023): "conventional SPI" of
    table 1, and the reference image of the object at rest.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import ClassVar

import numpy as np

from instrument.config import SchemePlugin
from instrument.plan import Plan
from instrument.schemes.columns import Column, in_play_order
from instrument.schemes.hadamard_pairs import HadamardSettings, hadamard_rows, pair_light, sequence_of
from instrument.schemes.scheme import ImageRows
from protocols import Bytes, Floats, PatternSequence


class HadamardPairSettings(HadamardSettings):
    """``[scheme]`` of conventional Hadamard imaging."""

    patterns_per_frame: ClassVar[int] = 2

    name: str = "hadamard"
    """The scheme."""


@dataclass(frozen=True)
class HadamardPairs:
    """Patterns and their meaning for one plan: H+, H-."""

    plan: Plan
    """The run that this scheme serves."""

    settings: HadamardPairSettings
    """The plan's ``[scheme]`` table."""

    name: ClassVar[str] = "hadamard"

    position: ClassVar[None] = None
    """No pattern measures position."""

    @cached_property
    def columns(self) -> tuple[Column, ...]:
        """The two patterns."""
        return in_play_order(Column(role="hadamard"), Column(role="hadamard", sign=-1))

    @cached_property
    def light_weights(self) -> Floats:
        """S = I_H+ + I_H-."""
        return pair_light(self.columns)

    @property
    def fixed_patterns(self) -> Bytes:
        """``(0, m, m)``: no pattern is the same in every frame."""
        return np.zeros((0, self.plan.image_size, self.plan.image_size), np.uint8)

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
    summary="two patterns: one Hadamard and its complement; the image of an object at rest",
    settings=HadamardPairSettings,
    make=HadamardPairs,
)
