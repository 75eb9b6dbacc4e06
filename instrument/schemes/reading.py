"""How the values of a frame become the object's position along x and y.

Each position pattern sees a share of the total light S that is linear in a *signal* of one or two parts,

    I_k / S = base_k + sum over parts of response_kp signal_p,

so that the signal is found from the values by least squares. For a Fourier pattern P = 1/2 + 1/2 cos(2 pi f u + phase) the base
is 1/2, the response (cos phase, sin phase) / 2, and the signal is the object's Fourier coefficient over S, as real and imaginary
part: its angle is -2 pi f p for an object at p. For a moment pattern P = u / m the base is 0, the response 1 / m, and the signal
is the position of the centroid itself.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeAlias

import numpy as np
from numpy.typing import NDArray

from instrument.schemes.columns import Axis, Column, Role
from instrument.schemes.ramps import Ramps
from instrument.schemes.turn import TurnReading
from protocols import Floats, Integers

Signals: TypeAlias = NDArray[np.complex128]
"""``(frames, 2)`` signals along x and y; the second part of a signal is its imaginary part."""


@dataclass(frozen=True, eq=False)
class PositionReading:
    """Position patterns of a scheme and what they see; see the module. Arrays begin with the axis: x, then y."""

    columns: Integers
    """``(2, k)``: columns of the values that measure each axis."""

    base: Floats
    """``(2, k)``: share of the total light that a pattern sees whatever the signal is."""

    response: Floats
    """``(2, k, parts)``: share that it sees for each part of the signal being 1."""

    after_middle_frames: Floats
    """``(2, k)``: middle of each pattern against the middle of its frame, in frames."""

    period_px: float | None
    """Displacement after which a two-part signal repeats; None where the signal is the position in px."""

    ramps: Ramps | None = None
    """Ramps of the first frames, which give the absolute position; None where there are none."""

    turn: TurnReading | None = None
    """Patterns that give the object's angle; None where there are none."""

    @cached_property
    def weights(self) -> Floats:
        """``(2, parts, k)``: least-squares inverse of ``response``."""
        turned = self.response.swapaxes(1, 2)
        return np.asarray(np.linalg.solve(turned @ self.response, turned), np.float64)

    @cached_property
    def offset(self) -> Floats:
        """``(2, parts)``: signal = weights I / S + offset."""
        return np.asarray(-np.einsum("apk,ak->ap", self.weights, self.base), np.float64)

    @cached_property
    def light_weights(self) -> Floats | None:
        """``(2, k)``: weights of an axis's values in the total light, as these tell it by themselves; None where they do not.

        Base and signal are found from the values by least squares, and the base times S is what is left without a signal. Three
        fringes of an axis tell it, and a ramp with its complement; two fringes or a ramp alone do not.
        """
        design = np.concatenate([self.base[..., None], self.response], axis=2)
        if (np.linalg.matrix_rank(design) < design.shape[2]).any():
            return None
        return np.asarray(np.linalg.pinv(design)[:, 0], np.float64)

    def signal(self, values: Floats, total: Floats) -> Signals:
        """Give the signal of each frame.

        Args:
            values: ``(frames, patterns_per_frame)`` light of each pattern.
            total: ``(frames,)`` total light S of each frame, above 0.
        """
        parts = np.einsum("apk,fak->fap", self.weights, values[:, self.columns]) / total[:, None, None] + self.offset
        return as_signals(parts)

    def shares(self, parts: Floats) -> Floats:
        """``(..., 2, k)``: share of the total light that each pattern sees of a signal, ``(..., 2, parts)``."""
        return np.asarray(self.base + np.einsum("akp,...ap->...ak", self.response, parts), np.float64)

    def direction(self, place_px: Floats) -> Floats:
        """``(..., parts)``: signal of amplitude 1 of an object at ``place_px``, ``(...)``."""
        if self.period_px is None:
            return place_px[..., None]
        angle = -2 * np.pi / self.period_px * place_px
        return np.stack([np.cos(angle), np.sin(angle)], axis=-1)

    def displacement_px(self, signals: Signals, reference: Signals | complex) -> Floats:
        """Displacement of each signal against a reference, within half a period either way (the paper, equation 6)."""
        if self.period_px is None:
            return np.asarray((signals - reference).real, np.float64)
        return np.asarray(-np.angle(signals * np.conj(reference)) * (self.period_px / (2 * np.pi)), np.float64)

    @property
    def origin(self) -> complex:
        """Reference against which displacement is the position itself."""
        return 0.0 if self.period_px is None else 1.0


def as_signals(parts: Floats) -> Signals:
    """``(..., parts)`` real numbers as ``(...)`` complex ones."""
    signals = np.zeros(parts.shape[:-1], np.complex128)
    signals.real = parts[..., 0]
    if parts.shape[-1] > 1:
        signals.imag = parts[..., 1]
    return signals


def fourier_reading(columns: Sequence[Column], period_px: float) -> PositionReading:
    """Read the Fourier patterns of a frame: two or more an axis, of different phases, as many along y as along x.

    Args:
        columns: all patterns of the frame.
        period_px: 1 / f.
    """
    number, after = _along_axes(columns, "fourier")
    phase = np.array([[columns[int(k)].phase_rad for k in axis] for axis in number])
    response = np.stack([np.cos(phase), np.sin(phase)], axis=-1).round(15) / 2
    return PositionReading(number, np.full(number.shape, 0.5), response, after, period_px)


def moment_reading(columns: Sequence[Column], size: int) -> PositionReading:
    """Read the moment patterns of a frame, as ``patterns.ramp`` makes them: grey (u + 1/2) / size at pixel u.

    There is one an axis, or one and its complement, whose column has the sign -1.

    Args:
        columns: all patterns of the frame.
        size: pixels a side of the field.
    """
    number, after = _along_axes(columns, "moment")
    sign = np.array([[columns[int(k)].sign for k in axis] for axis in number], np.float64)
    base = np.where(sign > 0, 0.5 / size, 1 - 0.5 / size)
    return PositionReading(number, base, sign[..., None] / size, after, period_px=None)


def _along_axes(columns: Sequence[Column], role: Role) -> tuple[Integers, Floats]:
    """Numbers of the columns of a role that measure x, and y, and their middles against the frame's, both ``(2, k)``."""
    axes: tuple[Axis, Axis] = ("x", "y")
    number = [[k for k, column in enumerate(columns) if (column.role, column.axis) == (role, axis)] for axis in axes]
    after = [[columns[k].after_middle_frames for k in axis] for axis in number]
    return np.array(number), np.array(after)
