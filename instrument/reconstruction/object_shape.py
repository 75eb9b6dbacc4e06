"""How an object is turned, and how large it is, during each pattern; and what fixed patterns see of it then."""

from dataclasses import dataclass
from typing import Self

import numpy as np

from instrument.numerics import compiled
from instrument.reconstruction.correlation import FixedPatterns
from instrument.reconstruction.turned_hadamard import corner_of
from instrument.tracking import Trajectory
from protocols import Floats, Singles


@dataclass(frozen=True, eq=False)
class ObjectShape:
    """How the object is turned about its pivot during each pattern of each valid frame, and how large it is."""

    pivot_px: Floats
    """``(2,)``: x, y of the pivot where the object is not displaced."""

    pair: Floats
    """``(rows, 2)``: angle in radians and logarithm of the magnification, in the middle between H+ and H-."""

    fixed: Floats
    """``(rows, k, 2)``: the same during each pattern that measures position."""

    @classmethod
    def along(cls, trajectory: Trajectory, time_s: Floats) -> Self | None:
        """Read a trajectory at the times of the patterns; None where it has no pivot.

        Args:
            trajectory: the path, with what is known of angle and magnification.
            time_s: ``(rows, 2 + k)``: times of H+, H- and the patterns that measure position, as in ``ImageValues``.
        """
        if trajectory.pivot_px is None:
            return None
        frames = len(trajectory)
        angle = np.zeros(frames) if trajectory.angle_deg is None else np.deg2rad(trajectory.angle_deg)
        growth = np.zeros(frames) if trajectory.magnification is None else np.log(trajectory.magnification)
        read = [np.interp(time_s, trajectory.time_s, series) for series in (angle, growth)]
        every: Floats = np.stack(read, axis=-1)
        return cls(trajectory.pivot_px, every[:, :2].mean(axis=1), every[:, 2:])

    def values(
        self, patterns: FixedPatterns, image: Singles, places_px: Floats, change: Floats
    ) -> tuple[Floats, Floats]:
        """Give the values that patterns measure of an image.

        Args:
            patterns: n patterns as they act.
            image: ``(height, width)`` image pixels of their region.
            places_px: ``(rows, n, 2)`` displacement x, y during each.
            change: ``(rows, n, 2)`` angle and logarithm of the magnification.

        Returns:
            The values, ``(rows, n)``, and their derivatives by x and y (1/px), ``(rows, n, 2)``.
        """
        grid = patterns.field.grid
        pose = np.concatenate([places_px * grid, change], axis=-1)
        values, slopes = np.zeros(pose.shape[:2]), np.zeros(places_px.shape)
        row, column = np.nonzero(image)
        left, top, pivot_x, pivot_y = corner_of(patterns.field, patterns.region, self.pivot_px)
        light = np.stack([column + left, row + top, image[row, column]]).astype(np.float64)
        weights = np.pad(patterns.patterns, ((0, 0), (1, 1), (1, 1)))
        _values(weights, pose, pivot_x, pivot_y, light, values, slopes)
        return values, slopes * grid


@compiled("void(f4[:, :, ::1], f8[:, :, ::1], f8, f8, f8[:, ::1], f8[:, ::1], f8[:, :, ::1])")
def _values(  # noqa: PLR0917
    patterns: Singles,
    pose: Floats,
    pivot_x: float,
    pivot_y: float,
    light: Floats,
    values: Floats,
    slopes: Floats,
) -> None:
    """Add up what ``ObjectShape.values`` gives: patterns, with a border of 0, are read by linear interpolation along both axes.

    Args:
        patterns: ``(n, size + 2, size + 2)``.
        pose: ``(rows, n, 4)`` in image pixels.
        pivot_x: place of the pivot.
        pivot_y: likewise.
        light: ``(3, pixels)`` x and y of each lit pixel against the pivot, and its light.
        values: ``(rows, n)``.
        slopes: ``(rows, n, 2)``.
    """
    end = patterns.shape[1] - 1
    for k in range(pose.shape[0]):
        for n in range(pose.shape[1]):
            larger = np.exp(pose[k, n, 3])
            cos, sin = larger * np.cos(pose[k, n, 2]), larger * np.sin(pose[k, n, 2])
            across, down = pivot_x + pose[k, n, 0] + 1, pivot_y + pose[k, n, 1] + 1
            for pixel in range(light.shape[1]):
                u = light[0, pixel] * cos - light[1, pixel] * sin
                v = light[0, pixel] * sin + light[1, pixel] * cos
                x, y = across + u, down + v
                if x < 0.0 or y < 0.0 or x >= end or y >= end:
                    continue
                i, j = int(x), int(y)
                part_x, part_y = x - i, y - j
                upper, lower = patterns[n, j, i], patterns[n, j + 1, i]
                step_up, step_low = patterns[n, j, i + 1] - upper, patterns[n, j + 1, i + 1] - lower
                upper, lower = upper + part_x * step_up, lower + part_x * step_low
                seen = larger * larger * light[2, pixel]
                values[k, n] += seen * (upper + part_y * (lower - upper))
                slopes[k, n, 0] += seen * (step_up + part_y * (step_low - step_up))
                slopes[k, n, 1] += seen * (lower - upper)
