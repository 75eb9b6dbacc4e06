"""An image that gets better while the run goes on."""

from dataclasses import replace
from typing import Final

import numpy as np
from scipy.ndimage import uniform_filter1d

from instrument.live.kept_frames import KeptFrames
from instrument.measurement import ImageValues, noise_variance
from instrument.numerics import EIGENVALUE_MARGIN, Operator, TvState, Weighted, close_border, total_variation
from instrument.plan import Plan
from instrument.reconstruction import Field, Region, ShiftedHadamard
from protocols import Floats, InputError, Singles

_FEWEST_FRAMES: Final = 16
"""Frames kept below which no image is made."""

_KEPT_SHARE: Final = 1 / 8
"""Patterns kept, over all Hadamard patterns: 2,048 for an image of 128 pixels a side."""

_SETTLED_SHARE: Final = 1 / 20
"""Frames kept, over all Hadamard patterns, from which on the strength is the usual one and edges are reweighted."""

_FIRST_STRENGTH: Final = 10.0
"""Strength of the smoothing at the start. It falls linearly to ``_STRENGTH`` at the settled share."""

_STRENGTH: Final = 3.0
"""Usual strength of the smoothing."""

_BURST_WORK: Final = 6e7
"""Rows times pixels times iterations of one burst: 10 to 15 ms on one core."""

_BURST_ITERATIONS: Final = (6, 60)
"""Fewest and most iterations of one burst."""

_BURST_TOLERANCE: Final = 0.02
"""Tolerance of ``total_variation`` at which a burst ends early."""

_POLISH_PLAIN_ITERATIONS: Final = 20
"""Fewest iterations of the polished image with unit weights."""

_POLISH_REWEIGHTED_ITERATIONS: Final = 60
"""Iterations of the polished image with edges reweighted."""

_COLD_ITERATIONS: Final = 150
"""Iterations that the polished image has behind it at least, earlier bursts included, before it is reweighted."""

_SAME_PLACE_PX: Final = 0.05
"""Root mean square distance between H+ and H- below which one row serves both, at half the work."""

_LAMP_FRAMES: Final = 25
"""Frames over which the total light is averaged to give the lamp's brightness."""

_LEAST_NOISE: Final = 5e-3
"""Noise assumed at least, over the root mean square value: with less the solver would spend itself on explaining every digit."""

_LEAST_LAMP: Final = 1e-3
"""Brightness assumed at least, over the lamp's mean."""

_TINY: Final = 1e-30
"""Smallest divisor."""


class ProgressiveImager:
    """Collects frames and improves one image of all it keeps.

    Memory is constant: see ``KeptFrames``. The structured rows are built anew for each burst of iterations (1 to 2 ms), so that
    the region shrinks as the path becomes known; the solver starts from its last result.

    All values count as equally noisy, as they nearly are when each pattern lets half of the light through; neither dead time nor
    dark counts are corrected. The analysis of the recording does better.
    """

    def __init__(self, plan: Plan, *, max_rows: int | None = None, edge_loss_a_side: float = 0.0) -> None:
        """Prepare for one run.

        Args:
            plan: what is shown. All frames are kept of a run of at most ``max_rows`` frames.
            max_rows: number of patterns kept; None takes an eighth of all Hadamard patterns, 2,048 for an image of 128 pixels a
                side.
            edge_loss_a_side: share of a pattern pixel's light that is lost at each side that borders a dark one.

        Raises:
            InputError: ``max_rows`` is below 16, or the scheme has no image.
        """
        patterns = plan.image_size**2
        if max_rows is None:
            max_rows = max(_FEWEST_FRAMES, round(_KEPT_SHARE * patterns))
        if max_rows < _FEWEST_FRAMES:
            raise InputError(
                saw=f"max_rows = {max_rows}", expected=f"{_FEWEST_FRAMES} or more", remedy="leave max_rows out"
            )
        room = min(max_rows, plan.frames, patterns)
        self._size = plan.image_size
        self._field = Field(plan.image_size, edge_loss=edge_loss_a_side)
        self._kept = KeptFrames(plan, room)
        self._settled_frames = min(room, _SETTLED_SHARE * patterns)
        self._iterations_done = 0
        self._region = Region.whole(plan.image_size)
        # Both belong to ``_region``; None before the first burst.
        self._state: TvState | None = None
        self._eigenvector: Singles | None = None

    @property
    def frames(self) -> int:
        """Number of frames seen, those without values included."""
        return self._kept.seen

    @property
    def rows(self) -> int:
        """Number of frames that the next image uses."""
        return len(self._kept)

    @property
    def region(self) -> Region:
        """Pixels where the last image may differ from 0."""
        return self._region

    @property
    def misfit(self) -> float:
        """Root mean square of what the last image leaves unexplained, over the noise; NaN before the first image."""
        return self._state.misfit if self._state else float("nan")

    @property
    def nbytes(self) -> int:
        """Memory of what is kept between bursts, in bytes."""
        if self._state is None or self._eigenvector is None:
            return self._kept.nbytes
        return self._kept.nbytes + self._state.image.nbytes + self._state.dual.nbytes + self._eigenvector.nbytes

    def add(self, values: Floats, displacement_px: Floats) -> None:
        """Take the next frames. Those that were not measured (NaN) are counted and not kept.

        Args:
            values: ``(n, patterns_per_frame)`` in play order.
            displacement_px: ``(n, 2)`` x, y in the middle of each frame, relative to frame 0, as ``StreamingTracker`` gives it.

        Raises:
            InputError: the arrays have other shapes.
        """
        patterns = self._kept.values.shape[1]
        if values.shape != (len(values), patterns) or displacement_px.shape != (len(values), 2):
            raise InputError(
                saw=f"values of shape {values.shape} and displacements of shape {displacement_px.shape}",
                expected=f"(n, {patterns}) and (n, 2)",
                remedy="add whole frames, with one displacement each",
            )
        if len(values):
            self._kept.add(values, displacement_px)

    def improve(self, iterations: int | None = None, *, effort: float = 1.0) -> Floats | None:
        """Spend a burst of iterations on the image of all frames kept, from where the last burst ended.

        An image of few frames is smoothed more. From a twentieth of all patterns on, edges that were found are reweighted.

        Args:
            iterations: number of iterations; None takes 6 to 60, as many as cost about the same for any number of rows.
            effort: factor on that cost.

        Returns:
            ``(m, m)``: the object at frame 0, row = y (down), column = x, in values for one lit pixel; None as long as there are
            fewer than 16 frames, or no light.
        """
        share = min(1.0, self.rows / self._settled_frames)
        strength = _FIRST_STRENGTH + share * (_STRENGTH - _FIRST_STRENGTH)
        return self._burst(strength, iterations, effort, reweighted=share == 1 and self._state is not None)

    def polish(self) -> Floats | None:
        """Bring the image to its end: a burst with unit weights, short where many went before, and a reweighted one.

        Returns:
            The image as ``improve`` gives it.
        """
        plain = max(_POLISH_PLAIN_ITERATIONS, _COLD_ITERATIONS - self._iterations_done)
        if self._burst(_STRENGTH, plain, reweighted=False) is None:
            return None
        return self._burst(_STRENGTH, _POLISH_REWEIGHTED_ITERATIONS, reweighted=True)

    def _burst(
        self, strength: float, iterations: int | None, effort: float = 1.0, *, reweighted: bool
    ) -> Floats | None:
        """Spend a burst of iterations, and give the image; None where there are too few frames or no light."""
        entries = self._kept.oldest_first()
        if len(entries) < _FEWEST_FRAMES or not self._kept.values[entries].any():
            return None
        region, stays_inside = self._region_of_the_object()
        rows, values = self._whitened(region, stays_inside=stays_inside)
        start = self._warm_start(rows, region)
        if start is None:
            return None
        if iterations is None:
            fewest, most = _BURST_ITERATIONS
            iterations = min(max(round(effort * _BURST_WORK / (rows.shape[0] * rows.shape[1])), fewest), most)
        self._state = total_variation(
            rows,
            values,
            strength=strength,
            reweightings=int(reweighted),
            tolerance=_BURST_TOLERANCE,
            iterations=iterations,
            start=start,
        )
        self._iterations_done += iterations
        return region.paste(self._state.image.astype(np.float64), self._size)

    def _region_of_the_object(self) -> tuple[Region, bool]:
        """Give the region of an object that stays inside the field, and whether there is one; else the whole field."""
        entries = self._kept.oldest_first()
        places_px = np.concatenate([self._kept.positive_px[entries], self._kept.negative_px[entries]])
        try:
            return Region.inside(places_px, self._size), True
        except InputError:
            return Region.whole(self._size), False

    def _whitened(self, region: Region, *, stays_inside: bool) -> tuple[Weighted, Singles]:
        """Give rows and values, ``(rows,)``, of the differences I_H+ - I_H-, both divided by their noise."""
        entries = self._kept.oldest_first()
        values = self._image_values(stays_inside=stays_inside)
        positive_px, negative_px = self._kept.positive_px[entries], self._kept.negative_px[entries]
        if float(np.sqrt(np.mean((negative_px - positive_px) ** 2))) <= _SAME_PLACE_PX:
            positive_px = negative_px = (positive_px + negative_px) / 2
        rows = ShiftedHadamard.differential(values.pairs, positive_px, negative_px, self._field, region)
        sigma = values.difference_sigma
        return Weighted(rows, (1 / sigma).astype(np.float32)), (values.difference / sigma).astype(np.float32)

    def _image_values(self, *, stays_inside: bool) -> ImageValues:
        """Give the values kept, with one variance for all, free of the lamp's changes where the object stays inside the field."""
        entries, scheme = self._kept.oldest_first(), self._kept.scheme
        values = self._kept.values[entries]
        least_sigma = _LEAST_NOISE * float(np.sqrt(np.mean(np.square(values))))
        measured = noise_variance(values, scheme.light_weights, np.ones(len(values), np.bool_))
        lamp = np.ones(len(values))
        if stays_inside:
            total = uniform_filter1d(values @ scheme.light_weights, _LAMP_FRAMES, mode="nearest")
            lamp = np.maximum(total / max(float(total.mean()), _TINY), _LEAST_LAMP)
        return ImageValues.of(
            scheme,
            frame=self._kept.frame[entries],
            pairs=self._kept.pairs[entries],
            values=values,
            variance=np.full_like(values, max(measured, least_sigma**2)),
            time_s=np.zeros_like(values),
            lamp=lamp,
            size=self._size,
            photon_counts=False,
        )

    def _warm_start(self, rows: Operator, region: Region) -> TvState | None:
        """Give the last result, cut to the new region, with the eigenvalue of the new rows; None where no light comes through.

        The power method starts from the eigenvector of the last rows, so that one step is enough.
        """
        if self._eigenvector is None:
            first = np.random.default_rng(0).random(region.shape).astype(np.float32)
            eigenvector, eigenvalue = _power_method(rows, first, steps=20)
        else:
            eigenvector, eigenvalue = _power_method(rows, _recut(self._eigenvector, self._region, region), steps=1)
        if eigenvalue <= 0:
            return None
        start = TvState.zero((region.shape,), eigenvalue)
        if self._state is not None:
            dual = _recut(self._state.dual, self._region, region)
            close_border(dual)
            dual *= np.float32(self._state.eigenvalue / eigenvalue)  # by which a dual variable is kept divided
            start = replace(start, images=(_recut(self._state.image, self._region, region),), duals=(dual,))
        self._eigenvector, self._region = eigenvector, region
        return start


def _power_method(rows: Operator, first: Singles, *, steps: int) -> tuple[Singles, float]:
    """Estimate eigenvector (not normalised, ``(height, width)``) and, from above, the largest eigenvalue of A'A."""
    vector, eigenvalue = first, 0.0
    for _ in range(steps):
        vector = vector / np.float32(max(float(np.linalg.norm(vector)), _TINY))
        vector = rows.rmatvec(rows.matvec(vector.ravel())).reshape(first.shape)
        eigenvalue = EIGENVALUE_MARGIN * float(np.linalg.norm(vector))
    return vector, eigenvalue


def _recut(part: Singles, old: Region, new: Region) -> Singles:
    """Cut ``(..., height, width)`` of one region to another, with zeros where they do not overlap."""
    out = np.zeros((*part.shape[:-2], *new.shape), np.float32)
    top, left = max(old.top, new.top), max(old.left, new.left)
    bottom = min(old.top + old.height, new.top + new.height)
    right = min(old.left + old.width, new.left + new.width)
    if bottom > top and right > left:
        inside = part[..., top - old.top : bottom - old.top, left - old.left : right - old.left]
        out[..., top - new.top : bottom - new.top, left - new.left : right - new.left] = inside
    return out
