"""The free numbers of the light model, fitted to what a prediction leaves of the values.

All of them change the values linearly, and all in ways that no smooth motion does: the amplitude of the position signals, the
fast part of them, and the fast part of the sum I_H+ + I_H-. One weighted regression gives them together, with their covariance:

* leak c: each value has c (v_(k-1) - v_k) too much, less half of what the total light has too much by it;
* edge loss: each position value has that share of the light at its pattern's borders too little, and half of what the total
  light, in which Hadamard patterns lost some, is too small;
* the offsets of the position signals, and a factor on their amplitude, as an image may be too smooth.
"""

from dataclasses import dataclass

import numpy as np
from scipy.ndimage import uniform_filter1d

from instrument.joint.evidence import directions_of
from instrument.joint.prediction import Prediction
from instrument.measurement import LightModel, Parameter, bordering_share, fixed_columns
from instrument.numerics import smooth
from instrument.reconstruction import Problem
from instrument.schemes import Scheme, image_rows_of, position_of
from protocols import Floats, Integers, Mask

_FAST_FRAMES = 9  # frames whose mean is taken off where only the fast part counts
_BLOCKS = 16  # parts of a run whose frames may deviate alike
_SIGNIFICANT = 3.0  # standard deviations from which on a number is taken
_KNOWN = 0.015  # standard deviation above which a run says too little: image and light could then mislead each other
_MOST_LEAK = 0.4  # a larger one is no leak but a wrong order of the patterns
_MOST_EDGE_LOSS = (
    0.2  # a larger one, at each of four sides, leaves no mirror: it is a background that was not seen as one
)
_OFFSET_PRIOR = (
    0.003  # standard deviation of an offset beyond the prediction before the run says anything, over the total light
)
_OTHER_PRIOR = 0.3  # of leak, edge loss a side, and the relative error of an amplitude
_TINY = 1e-12


@dataclass(frozen=True, eq=False)
class LightFit:
    """What a regression found."""

    light: LightModel
    """The light model, with what the data determine."""

    offset: Floats
    """``(k,)``: share of the total light that each position value has beyond the prediction."""

    offset_covariance: Floats
    """``(k, k)``: its covariance."""


def fit_light(problem: Problem, prediction: Prediction, light: LightModel, superpixel: int) -> LightFit:
    """Fit the light model to what a prediction leaves; see the module.

    Args:
        problem: values, corrected by the light model so far.
        prediction: what images predict with the light model so far.
        light: the light model so far. Numbers that were given or calibrated are kept.
        superpixel: mirrors a pattern pixel has along each side.
    """
    regression = _Regression.of(problem, prediction)
    free = {"leak": light.leak.free, "edge_loss": light.edge_loss.free}
    found, covariance = regression.solved(**free)
    leak = light.leak.value + (1 - light.leak.value) * found[0]
    edge_loss = light.edge_loss.value + superpixel * found[1]
    sigma = np.sqrt(np.diagonal(covariance))
    fitted: dict[str, Parameter] = {}
    if free["leak"]:
        fitted["leak"] = _taken(leak, sigma[0], _MOST_LEAK)
    if free["edge_loss"]:
        fitted["edge_loss"] = _taken(edge_loss, superpixel * sigma[1], _MOST_EDGE_LOSS)
    refused = {name for name, parameter in fitted.items() if parameter.source != "fitted"}
    if refused:  # the offsets are to be those of a model without them
        found, covariance = regression.solved(**{name: asked and name not in refused for name, asked in free.items()})
    offset, offset_covariance = regression.offsets(found, covariance)
    return LightFit(light.model_copy(update=fitted), offset, offset_covariance)


def _taken(value: float, sigma: float, most: float) -> Parameter:
    """Give a fitted number, where it differs from 0 by more than chance; else 0 as it was assumed, with what is known of it."""
    if not np.isfinite([value, sigma]).all():
        return Parameter(value=0.0)
    if sigma > _KNOWN or value < _SIGNIFICANT * sigma or value > most:
        return Parameter(value=0.0, sigma=float(sigma))
    return Parameter(value=float(value), sigma=float(sigma), source="fitted")


@dataclass(frozen=True, eq=False)
class _Regression:
    """Residuals in units of their noise, and their derivatives by leak, edge loss, and each axis's offsets and amplitude."""

    residual: Floats
    """``(n,)``."""

    design: Floats
    """``(n, unknowns)``."""

    kinds: int
    """Kinds of residuals that follow each other, each with one for every frame."""

    is_offset: Mask
    """``(unknowns,)``: whether an unknown is part of an offset."""

    parts: list[Floats]
    """For each axis with an amplitude, ``(unknowns, k)``: how the unknowns become offsets of the k position values."""

    @classmethod
    def of(cls, problem: Problem, prediction: Prediction) -> "_Regression":
        """Set it up; see the module."""
        reading, values = position_of(problem.scheme), problem.values
        before, hadamard_before = _leaks(problem.scheme, prediction, values.frame)
        residual = values.fixed - prediction.values
        half_lost = prediction.total * bordering_share(values.pairs, values.size) / 2
        half_leaked = smooth(hadamard_before, np.ones(len(hadamard_before)), orders=(1,)).values / 2
        k, parts = residual.shape[1], reading.response.shape[2]
        unknowns = 2 + 2 * (parts + 1)
        sides: list[tuple[Floats, Floats]] = []
        to_offset: list[Floats] = []
        is_offset = np.zeros(unknowns, np.bool_)
        for axis in range(2):
            directions = directions_of(problem, prediction, axis)
            own = directions.columns
            leak = before[:, own] - half_leaked[:, None]
            loss = half_lost[:, None] - prediction.bordering[:, own]
            design = np.zeros((len(residual), unknowns))
            design[:, 0] = np.sum(directions.along * leak, axis=1)
            sides.append((_fast(np.sum(directions.along * residual[:, own], axis=1)), _fast(design)))
            if directions.across is None:
                continue
            first = 2 + axis * (parts + 1)
            of_parts = prediction.total[:, None, None] * reading.response[axis]
            signal = prediction.values[:, own] - prediction.total[:, None] * reading.base[axis]
            design = np.zeros((len(residual), unknowns))
            for column, change in ((0, leak), (1, loss), (first + parts, signal)):
                design[:, column] = np.sum(directions.across * change, axis=1)
            design[:, first : first + parts] = np.einsum("rk,rkp->rp", directions.across, of_parts)
            sides.append((np.sum(directions.across * residual[:, own], axis=1), design))
            is_offset[first : first + parts] = True
            offsets = np.zeros((unknowns, k))
            offsets[first : first + parts, own] = reading.response[axis].T
            to_offset.append(offsets)
        pair_sigma = values.difference_sigma
        design = np.zeros((len(residual), unknowns))
        design[:, 0] = hadamard_before / pair_sigma
        pair_sum = (values.positive + values.negative - prediction.total) / pair_sigma
        sides.append((_fast(pair_sum), _fast(design)))
        return cls(
            np.concatenate([r for r, _ in sides]),
            np.concatenate([d for _, d in sides]),
            len(sides),
            is_offset,
            to_offset,
        )

    def solved(self, *, leak: bool, edge_loss: bool) -> tuple[Floats, Floats]:
        """Give the unknowns and their covariance; an unknown that is not asked for is 0.

        Where neighbouring frames deviate alike, because an image is not yet right, the deviations say less than as many chance
        ones would: the variance of each unknown is at least the one that blocks of frames show (a sandwich estimator).
        """
        design = self.design.copy()
        design[:, [k for k, asked in enumerate((leak, edge_loss)) if not asked]] = 0
        prior = np.full(design.shape[1], _OTHER_PRIOR)
        prior[self.is_offset] = _OFFSET_PRIOR
        information = design.T @ design + np.diag(prior**-2)
        covariance = np.linalg.inv(information)
        found = covariance @ (design.T @ self.residual)
        left = (self.residual - design @ found).reshape(self.kinds, -1)
        of_blocks = np.array_split(np.arange(left.shape[1]), _BLOCKS)
        by_kind = design.reshape(self.kinds, -1, design.shape[1])
        scores = np.stack([np.einsum("kn,knu->u", left[:, block], by_kind[:, block]) for block in of_blocks])
        together = covariance @ (scores.T @ scores) @ covariance
        larger = np.maximum(np.diagonal(together) / np.diagonal(covariance), 1.0)
        widened = covariance * np.sqrt(np.outer(larger, larger))
        return np.asarray(found, np.float64), np.asarray(widened, np.float64)

    def offsets(self, found: Floats, covariance: Floats) -> tuple[Floats, Floats]:
        """Give the offsets ``(k,)`` of the position values, and their covariance ``(k, k)``."""
        if not self.parts:
            return np.zeros(1), np.zeros((1, 1))
        both = np.sum(self.parts, axis=0)
        return found @ both, np.asarray(both.T @ covariance @ both, np.float64)


def _leaks(scheme: Scheme, prediction: Prediction, frame: Integers) -> tuple[Floats, Floats]:
    """Give v_(k-1) - v_k of each position pattern, ``(rows, k)``, and summed over H+ and H-, ``(rows,)``; 0 where unknown."""
    rows, position = image_rows_of(scheme), fixed_columns(scheme)
    light = np.repeat(prediction.total[:, None], len(scheme.columns), axis=1)
    light[:, position] = prediction.values
    light[:, rows.positive] = (prediction.total + prediction.difference) / 2
    light[:, rows.negative] = (prediction.total - prediction.difference) / 2
    for column in (rows.positive, rows.negative):
        light[rows.is_ramp(frame), column] = np.nan  # no Hadamard pair: not predicted
    before = np.concatenate([[np.nan], light.ravel()[:-1]]).reshape(light.shape)
    before[1:, 0][np.diff(frame) != 1] = np.nan
    change = np.nan_to_num(before - light)
    return change[:, position], change[:, rows.positive] + change[:, rows.negative]


def _fast(series: Floats) -> Floats:
    """Take off the mean over neighbouring frames, of ``(rows, ...)``."""
    return np.asarray(series - uniform_filter1d(series, _FAST_FRAMES, axis=0, mode="nearest"), np.float64)
