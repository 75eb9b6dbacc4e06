"""The six-pattern scheme: four binary Fourier patterns, one Hadamard pattern and its complement in each frame.

References:
    Li, Cai, Wang, Yao, Zhao, "Single-pixel imaging of a translational object", Opt. Express (2023), called *the paper*.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from instrument.patterns import fourier_pattern, hadamard_order, hadamard_signs
from instrument.plan import Plan
from protocols import Bytes, Floats, Integers, PatternSequence

_QUARTER = np.pi / 2
_HADAMARDS_AT_ONCE = 512  # of 16 kB each: keeps the unpacked signs below 10 MB


@dataclass(frozen=True, eq=False)
class Decoded:
    """What the values of frames say, before any tracking."""

    total: Floats
    """``(frames,)``: S = I_H+ + I_H-, the light of the whole field."""

    coefficient: NDArray[np.complex128]
    """``(frames, 2)``: Fourier coefficients O~(f, 0) and O~(0, f), in units of light."""

    hadamard: Floats
    """``(frames,)``: I_H = I_H+ - I_H-, the Hadamard coefficient."""


@dataclass(frozen=True)
class FourierHadamard:
    """Patterns and decoding of one plan.

    A frame's six values, in play order: x fringe at 0 and pi/2, y fringe at 0 and pi/2, H+, H-.
    """

    plan: Plan
    """The run that this scheme serves."""

    @property
    def patterns_per_frame(self) -> int:
        """Six: four Fourier patterns, a Hadamard pattern and its complement."""
        return self.plan.patterns_per_frame

    @property
    def samples(self) -> int:
        """Pattern samples a side."""
        return self.plan.image_size * self.plan.upsampling

    @cached_property
    def fourier(self) -> Bytes:
        """``(4, samples, samples)`` of 0 and 1: P(f,0,0), P(f,0,pi/2), P(0,f,0), P(0,f,pi/2), dithered."""
        plan = self.plan
        return np.stack(
            [
                fourier_pattern(plan.image_size, plan.fourier_cycles, phase, axis, plan.upsampling)
                for axis in ("x", "y")
                for phase in (0.0, _QUARTER)
            ]
        )

    @cached_property
    def order(self) -> Integers:
        """``(frames, 2)``: Walsh rows (c_i down, c_j across) of each frame's Hadamard pattern, in time order."""
        plan = self.plan
        chosen = hadamard_order(plan.image_size, plan.hadamard_order, min(plan.frames, plan.image_size**2))
        if plan.shuffle_seed is not None:
            chosen = np.random.default_rng(plan.shuffle_seed).permutation(chosen)
        return chosen[np.arange(plan.frames) % len(chosen)]

    def sequence(self, columns: int = 1024, rows: int = 768) -> PatternSequence:
        """Unique planes and play order for a modulator of ``columns`` x ``rows`` mirrors, guard picture included.

        Planes: the four Fourier patterns, then H+ and H- of each different Hadamard pattern. The complement of the all-one
        Hadamard pattern is dark and serves as guard; where it is not shown, a dark plane is added.

        Raises:
            PlanError: the field does not fit on the mirrors.
        """
        plan = self.plan
        unique = self.order[: plan.image_size**2]
        packed = [np.packbits(self.fourier, axis=-1)]
        for first in range(0, len(unique), _HADAMARDS_AT_ONCE):
            signs = hadamard_signs(plan.image_size, unique[first : first + _HADAMARDS_AT_ONCE])
            lit = np.stack([signs > 0, signs < 0], axis=1).reshape(-1, plan.image_size, plan.image_size)
            packed.append(np.packbits(lit.repeat(plan.upsampling, 1).repeat(plan.upsampling, 2), axis=-1))
        planes = np.concatenate(packed)
        dark = np.flatnonzero(~planes.any(axis=(1, 2)))
        if not len(dark):
            planes = np.concatenate([planes, np.zeros_like(planes[:1])])
            dark = np.array([len(planes) - 1])

        frame = np.arange(plan.frames) % len(unique)
        play = np.empty((plan.frames, self.patterns_per_frame), np.int64)
        play[:, :4] = np.arange(4)
        play[:, 4] = 4 + 2 * frame
        play[:, 5] = 5 + 2 * frame
        order = np.concatenate([play.ravel(), dark[:1]])
        return PatternSequence(planes=planes, play_order=order, grid=plan.grid(columns, rows), samples=self.samples)

    def decode(self, values: Floats, total: Floats | None = None) -> Decoded:
        """Turn values into coefficients (the paper, equations 8 and 9).

        Args:
            values: ``(frames, 6)`` in play order.
            total: ``(frames,)`` a better estimate of S to use in the coefficients; None takes I_H+ + I_H- of each frame.

        Returns:
            O~(f, 0) = (2 I_x0 - S) + j (2 I_x90 - S), O~(0, f) likewise, S, and I_H.
        """
        light = values[:, 4] + values[:, 5] if total is None else total
        coefficient = np.stack(
            [
                (2 * values[:, 0] - light) + 1j * (2 * values[:, 1] - light),
                (2 * values[:, 2] - light) + 1j * (2 * values[:, 3] - light),
            ],
            axis=1,
        )
        return Decoded(total=light, coefficient=coefficient, hadamard=values[:, 4] - values[:, 5])
