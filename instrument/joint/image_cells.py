"""The unknown pixels of an image as a few large cells, and how the values change with each: for linear algebra with all of them.

A cell is a square of whole pattern pixels, one where that makes few enough of them.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from instrument.joint.detail import Picture
from instrument.joint.prediction import Prediction
from instrument.reconstruction import Problem, walsh_rows
from instrument.schemes import position_of
from protocols import Floats, Integers, Mask, Singles

_LIT: Final = 0.15
"""Part of the typical transmission from which on a cell is the object's, and with it those next to it."""

_MOST: Final = 1500
"""Lit pixels that are looked at one by one; where the object has more, squares of them are."""

_EDGE: Final = 0.2
"""Step, in typical transmissions, at which the solver halves its penalty, as in ``total_variation``."""

_STEP_VARIANCE: Final = 3.0
"""Variance of each of the two components of a gradient g, in units of lambda^-2, if its probability is exp(-lambda |g|)."""

_TINY: Final = 1e-12


@dataclass(frozen=True, eq=False)
class Cells:
    """One of the unknown images."""

    problem: Problem
    """The problem, on the patterns' grid."""

    image: Floats
    """``(height, width)``: mean transmission of each cell."""

    lit: Mask
    """``(height, width)``: cells that are unknown; the others are dark."""

    times: int
    """Pattern pixels a side of a cell."""

    strength: float
    """Strength of the smoothing."""

    moves: bool
    """Whether it is the object's, and not of what stands still."""

    def rows(self, chosen: slice) -> Singles:
        """``(rows, cells)``: derivatives of some whitened Hadamard values by the unknown cells."""
        problem, field, area = self.problem, self.problem.field, self.problem.region
        pairs, sigma = problem.values.pairs[chosen], problem.values.difference_sigma[chosen]
        if self.moves and problem.places.shape is not None:
            turned = problem.turned_rows()
            matrix = replace(turned, pairs=pairs, pose=turned.pose[chosen]).matrix()
            cells = self._summed(self._summed(matrix.reshape(-1, area.height, area.width), 1), 2)[:, self.lit]
        else:
            place_px = problem.places.pair_px[chosen] if self.moves else np.zeros((len(pairs), 2))
            first, count = ((area.top, area.left), area.shape) if self.moves else ((0, 0), (field.size, field.size))
            down, across = (
                self._summed(walsh_rows(field, pairs[:, k], place_px[:, 1 - k], first[k], count[k]), 1) for k in (0, 1)
            )
            y, x = np.nonzero(self.lit)
            cells = down[:, y] * across[:, x]
        return np.asarray(cells / sigma[:, None], np.float32)

    def of_position(self, alongs: Sequence[Floats], positions: Sequence[Floats], prediction: Prediction) -> Floats:
        """``(cells, modes)``: derivatives of the position values by the unknown cells, times those by the modes.

        The light that an image has is taken from what is spread over the field, or scales all, as ``Predictor`` has it. What
        stands still gives each position value an offset, which is fitted.

        Args:
            alongs: for each axis, ``(rows, k)`` weights of all position values in the one that a motion changes.
            positions: for each axis, ``(rows, modes)`` derivatives of that one.
            prediction: position values and total light.
        """
        problem = self.problem
        found = np.zeros((np.count_nonzero(self.lit), positions[0].shape[1]))
        if not self.moves:
            return found
        fringes = position_of(problem.scheme).period_px is not None
        share = np.full_like(prediction.values, 0.5) if fringes else prediction.values / prediction.total[:, None]
        every = problem.fixed_patterns(problem.places.fixed)
        for along, position in zip(alongs, positions, strict=True):
            used: Integers = np.flatnonzero(along.any(axis=0))
            weights = np.einsum("rk,rm->rkm", along[:, used], position)
            found -= np.einsum("rk,rkm->m", share[:, used], weights) * self.times**2
            patterns = replace(every, patterns=every.patterns[used])
            maps = patterns.sampling(problem.places.fixed[:, used]).T @ weights.reshape(-1, weights.shape[2])
            for mode in np.flatnonzero(maps.any(axis=0)):
                own = maps[:, mode].astype(np.float32).reshape(len(used), every.width, every.width)
                found[:, mode] += self._summed(self._summed(patterns.image(own), 0), 1)[self.lit]
        return found

    def precision(self) -> Floats:
        """``(cells, cells)``: prior precision that the solver's penalty stands for.

        A step between neighbours has the variance that its penalty gives it, and that of the step that was found: edges are free.
        """
        penalty = self.strength * self.times * float(np.sqrt(np.sum(1 / self.problem.values.difference_variance)))
        edge = _EDGE * _typical(self.image)
        number = np.full(self.lit.shape, -1)
        number[self.lit] = np.arange(np.count_nonzero(self.lit))
        precision = np.zeros((number.max() + 1, number.max() + 1))
        for image, cell in ((self.image, number), (self.image.T, number.T)):
            step = np.abs(np.diff(image, axis=0))
            weight = 1 / (_STEP_VARIANCE * ((step + edge) / (penalty * edge)) ** 2 + step**2)
            for near, far in ((cell[:-1], cell[1:]), (cell[1:], cell[:-1])):
                there, both = near >= 0, (near >= 0) & (far >= 0)
                precision[near[there], near[there]] += weight[there]
                precision[near[both], far[both]] -= weight[both]
        return precision

    def _summed(self, pixels: Singles, axis: int) -> Singles:
        """Add up the pixels of each cell along an axis."""
        return _sums(pixels, axis, self.times)


def cells_of(picture: Picture) -> list[Cells]:
    """Give the cells of an object's image, and those of the image of what stands still where it is unknown too."""
    grid, problem = picture.iterate.problem.field.grid, picture.iterate.problem.on_grid(1)
    found: list[Cells] = []
    for finer, pixels, moves in zip((grid, 1), picture.state.images, (True, False), strict=False):
        lit = np.count_nonzero(pixels > _LIT * _typical(pixels)) / finer**2
        times = max(1, int(np.ceil(np.sqrt(lit / _MOST))))
        side = finer * times
        image = _sums(_sums(pixels, 0, side), 1, side).astype(np.float64) / side**2
        lit_cells = _and_around(image > _LIT * _typical(image))
        found.append(Cells(problem, image, lit_cells, times, picture.strength, moves))
    return found


def _typical(image: Floats | Singles) -> float:
    """Typical transmission: the mean over the image, each pixel weighted by its own transmission, as in ``total_variation``."""
    return float(np.sum(np.square(image, dtype=np.float64)) / max(float(image.sum(dtype=np.float64)), _TINY))


def _sums(pixels: Singles, axis: int, count: int) -> Singles:
    """Add up ``count`` pixels each along an axis; the last sum may be of fewer."""
    first = np.arange(0, int(pixels.shape[axis]), count, dtype=np.int64)
    return pixels if count == 1 else np.asarray(np.add.reduceat(pixels, first, axis=axis), np.float32)


def _and_around(lit: Mask) -> Mask:
    """Add the neighbours of what is lit."""
    around = np.pad(lit, 1)
    return lit | around[:-2, 1:-1] | around[2:, 1:-1] | around[1:-1, :-2] | around[1:-1, 2:]
