"""The Hadamard half of a scheme: which pattern each frame shows, and planes and play order of a whole run."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from pydantic import Field

from instrument.config import SchemeSettings
from instrument.patterns import HadamardOrder, hadamard_order, hadamard_signs
from instrument.plan import Plan
from instrument.schemes.columns import Column
from instrument.schemes.scheme import ImageRows
from protocols import Bytes, Floats, Integers, PatternSequence

_HADAMARDS_AT_ONCE = 512  # of 16 kB each: keeps the unpacked signs below 10 MB


class HadamardSettings(SchemeSettings):
    """Settings of every scheme that shows Hadamard patterns."""

    hadamard_order: HadamardOrder = "tv"
    """In which order Hadamard patterns are taken; see ``patterns.hadamard_order``."""

    order_seed: int = Field(default=0, ge=0)
    """Seed of the order ``random``; the others have none."""

    shuffle_seed: int | None = Field(default=None, ge=0)
    """Shuffle the chosen Hadamard patterns in time by this seed: better early images. None keeps the order."""


class DitheredSettings(SchemeSettings):
    """Settings of every scheme that shows grey patterns made binary by dithering."""

    upsampling: int = Field(default=1, gt=0)
    """Dithering samples a side of one image pixel. Must divide the plan's ``superpixel``."""

    def check(self, image_size: int, superpixel: int) -> None:
        """Refuse samples that are no whole mirrors."""
        super().check(image_size, superpixel)
        if superpixel % self.upsampling:
            raise ValueError(
                f"scheme.upsampling is {self.upsampling}: it must divide superpixel = {superpixel}, the mirrors a pixel side"
            )


def hadamard_rows(plan: Plan, settings: HadamardSettings, columns: Sequence[Column], ramp_frames: int = 0) -> ImageRows:
    """List the Hadamard pattern of each frame, in time order, and the columns of H+ and H-.

    Args:
        plan: the run.
        settings: order of the patterns.
        columns: all patterns of a frame.
        ramp_frames: frames at the start, and again after each m^2 frames, that show a ramp in the place of H+; the Hadamard
            patterns begin after them.
    """
    positive, negative = (
        next(k for k, column in enumerate(columns) if (column.role, column.sign) == ("hadamard", sign))
        for sign in (1, -1)
    )
    of_cycle = np.arange(plan.frames) % plan.image_size**2
    chosen = _chosen(plan, settings, max(1, len(np.unique(of_cycle)) - ramp_frames))
    pairs = chosen[(of_cycle - ramp_frames) % len(chosen)]
    if not ramp_frames:
        return ImageRows(pairs, positive, negative)
    ramps = np.asarray(of_cycle < ramp_frames, np.bool_)
    return ImageRows(np.where(ramps[:, None], 0, pairs), positive, negative, ramps)


def pair_light(columns: Sequence[Column]) -> Floats:
    """Weights of the total light S = I_H+ + I_H-, as a pattern and its complement add to the all-one pattern."""
    return np.array([1.0 if column.role == "hadamard" else 0.0 for column in columns])


def _chosen(plan: Plan, settings: HadamardSettings, count: int) -> Integers:
    """``(count, 2)``: Walsh rows (c_i down, c_j across) of the Hadamard patterns that are shown, in time order."""
    chosen = hadamard_order(plan.image_size, settings.hadamard_order, count, settings.order_seed)
    if settings.shuffle_seed is not None:
        chosen = np.random.default_rng(settings.shuffle_seed).permutation(chosen)
    return chosen


def sequence_of(
    plan: Plan, fixed: Bytes, pairs: Integers | None, ramps: Bytes | None = None, **mirrors: Any
) -> PatternSequence:
    """Planes and play order of frames that show the fixed patterns, then H+ and H- of their Hadamard pattern.

    Planes: the fixed patterns, then H+ and H- of each different Hadamard pattern. The complement of the all-one Hadamard
    pattern is dark and serves as guard; where it is not shown, a dark plane is added.

    Args:
        plan: the run.
        fixed: ``(n, samples, samples)`` of 0 and 1, shown in every frame; n may be 0.
        pairs: ``(frames, 2)`` of ``ImageRows``; None where no Hadamard patterns are shown.
        ramps: ``(n, samples, samples)`` of 0 and 1, each shown with its complement in the place of the pair of one of the first
            frames, and again after each m^2 frames; None for none.
        mirrors: ``columns`` and ``rows`` of the modulator.

    Raises:
        PlanError: the field does not fit on the mirrors.
    """
    size, samples = plan.image_size, fixed.shape[-1]
    unique = np.zeros((0, 2), np.int64) if pairs is None else pairs[: size**2]
    finer = samples // size
    packed = [np.packbits(fixed, axis=-1)]
    for first in range(0, len(unique), _HADAMARDS_AT_ONCE):
        signs = hadamard_signs(size, unique[first : first + _HADAMARDS_AT_ONCE])
        lit = np.stack([signs > 0, signs < 0], axis=1).reshape(-1, size, size)
        packed.append(np.packbits(lit.repeat(finer, 1).repeat(finer, 2), axis=-1))
    if ramps is not None:  # in the place of the all-on patterns that stand for them among the pairs
        shown = ramps[: len(unique)]
        both = np.packbits(np.stack([shown, 1 - shown], axis=1).reshape(-1, samples, samples), axis=-1)
        packed = [packed[0], both, np.concatenate(packed[1:])[len(both) :]]
    planes = np.concatenate(packed)
    dark = np.flatnonzero(~planes.any(axis=(1, 2)))
    if not len(dark):
        planes = np.concatenate([planes, np.zeros_like(planes[:1])])
        dark = np.array([len(planes) - 1])

    play = np.empty((plan.frames, plan.patterns_per_frame), np.int64)
    play[:, : len(fixed)] = np.arange(len(fixed))
    if len(unique):
        positive = len(fixed) + 2 * (np.arange(plan.frames) % len(unique))
        play[:, len(fixed)], play[:, len(fixed) + 1] = positive, positive + 1
    order = np.concatenate([play.ravel(), dark[:1]])
    return PatternSequence(planes=planes, play_order=order, grid=plan.grid(**mirrors), samples=samples)
