"""What a scheme is: the patterns of one frame, and what the light of each pattern says.

A scheme is the only place that knows in which column of the values a pattern stands. Whoever needs position or image asks for
the scheme's ``position`` or ``image_rows``; a scheme may lack either of them.
"""

from dataclasses import dataclass
from typing import Protocol, runtime_checkable

import numpy as np

from instrument.schemes.columns import Column
from instrument.schemes.reading import PositionReading
from protocols import Bytes, Floats, InputError, Integers, Mask, PatternSequence


@dataclass(frozen=True, eq=False)
class ImageRows:
    """The Hadamard pattern of each frame, shown as H+ = (1 + H)/2 and as its complement H- = (1 - H)/2."""

    pairs: Integers
    """``(frames, 2)``: Walsh rows (c_i down, c_j across) of each frame's pattern H = w_i(y) w_j(x)."""

    positive: int
    """Column of H+."""

    negative: int
    """Column of H-."""

    ramps: Mask | None = None
    """``(frames,)``: whether a frame shows a ramp and its complement in the place of a pair, of which the sum alone says
    something of the image: that of the all-on pattern, pair (0, 0). None for never."""

    def is_ramp(self, frame: Integers) -> Mask:
        """Give whether some frames, ``(n,)``, show a ramp and its complement."""
        if self.ramps is None:
            return np.zeros(len(frame), np.bool_)
        return np.asarray(self.ramps[frame % len(self.ramps)], np.bool_)

    def as_pairs(self, values: Floats, frame: Integers) -> Floats:
        """Give the values of some frames, ``(n, patterns_per_frame)``, as those of Hadamard pairs: all on and dark for a ramp."""
        ramp = self.is_ramp(frame)
        if not ramp.any():
            return values
        pairs = values.copy()
        pairs[ramp, self.positive] += values[ramp, self.negative]
        pairs[ramp, self.negative] = 0.0
        return pairs


@runtime_checkable
class Scheme(Protocol):
    """Patterns and their meaning for one plan. Making one is cheap: patterns are synthesised when they are asked for."""

    @property
    def name(self) -> str:
        """Name under which the scheme is installed."""
        ...

    @property
    def columns(self) -> tuple[Column, ...]:
        """Patterns of a frame in play order."""
        ...

    @property
    def light_weights(self) -> Floats:
        """``(patterns_per_frame,)``: the total light S of a frame is the sum of its values times these weights."""
        ...

    @property
    def position(self) -> PositionReading | None:
        """How the values of a frame give the object's position; None for a scheme that sees no position."""
        ...

    @property
    def fixed_patterns(self) -> Bytes:
        """``(n, samples, samples)`` of 0 and 1: the pattern of every column but those of ``image_rows``, in their order.

        They are the same in every frame. Some may measure no position, such as an all-on pattern for the total light. ``samples``
        is a multiple of the plan's ``image_size`` that divides the mirrors of the field; n may be 0.
        """
        ...

    @property
    def image_rows(self) -> ImageRows | None:
        """What each frame says of the image; None for a scheme that only tracks."""
        ...

    def sequence(self, columns: int = 1024, rows: int = 768) -> PatternSequence:
        """Unique planes and play order for a modulator of ``columns`` x ``rows`` mirrors, guard picture included.

        Raises:
            PlanError: the field does not fit on the mirrors.
        """
        ...


def position_of(scheme: Scheme) -> PositionReading:
    """How a scheme's values give the object's position.

    Raises:
        InputError: the scheme sees no position.
    """
    if scheme.position is None:
        raise InputError(
            saw=f"the scheme {scheme.name}, whose patterns see no position",
            expected="a scheme that tracks",
            remedy='record with another scheme, such as "fourier-hadamard", or reconstruct the object as one at rest',
        )
    return scheme.position


def image_rows_of(scheme: Scheme) -> ImageRows:
    """What the frames of a scheme say of the image.

    Raises:
        InputError: the scheme only tracks.
    """
    if scheme.image_rows is None:
        raise InputError(
            saw=f"the scheme {scheme.name}, which only tracks",
            expected="a scheme that shows Hadamard patterns too",
            remedy='record with another scheme, such as "fourier-hadamard"',
        )
    return scheme.image_rows
