"""An image that gets better while the run goes on."""

from typing import Final

import numpy as np
from scipy.ndimage import uniform_filter1d

from instrument.measurement import ImageValues, noise_variance
from instrument.numerics import CORNERS, Operator, TvState, Weighted, total_variation
from instrument.plan import Plan
from instrument.reconstruction import Region, ShiftedHadamard
from instrument.schemes import image_rows_of, scheme_of
from protocols import Floats, InputError, Integers, Singles

FEWEST_ROWS: Final = 16
"""Frames below which there is no image."""

_KEPT_SHARE = 1 / 8  # of all Hadamard patterns: 2,048 rows at 128 px
_SETTLED_SHARE = 1 / 20  # of all Hadamard patterns: before, smooth more; after, free the edges found
_STRENGTH = (10.0, 3.0)  # of the smoothing, at the start and from the settled share on
_BURST = 6e7  # rows times pixels times iterations of a burst: 10 to 15 ms on one core
_BURST_LIMITS = (6, 60)
_TOLERANCE = 0.02  # at which a burst ends early
_POLISH = (20, 60)  # iterations without and with edges freed
_FROM_NOTHING = 150  # iterations of an image that had no earlier ones
_SAME_PLACE_PX = 0.05  # rms distance from H+ to H- below which one row does for both: half the work
_LIGHT_FRAMES = 25  # over which the total light is averaged
_LEAST_NOISE = 5e-3  # of the rms value: with less, the solver would take many solutions to explain every digit
_ABOVE = 1.05  # the power method approaches the largest eigenvalue from below
_POWER_STEPS = (20, 1)  # at first, and from where the last burst ended


class ProgressiveImager:
    """Collects frames and improves one image of all it keeps.

    Memory is constant: it keeps one frame, the newest, of each of the first ``max_rows`` Hadamard patterns in play order. A
    longer run renews them when the patterns come again; frames of other patterns only count. (The newest frames of a long run
    would be of fine patterns alone, and show nothing.) The structured rows are built anew for
    each burst of iterations (1 to 2 ms), so that the region shrinks as the path becomes known; the solver goes on from
    where it was.

    All values count as equally noisy, as they nearly are when each pattern lets half of the light through; neither dead time nor
    dark counts are corrected. The analysis of the recording does better.
    """

    def __init__(self, plan: Plan, *, max_rows: int | None = None) -> None:
        """Prepare for one run.

        Args:
            plan: what is shown. Of a run of at most ``max_rows`` frames all are kept.
            max_rows: patterns kept; None takes an eighth of all Hadamard patterns, 2,048 for an image of 128 pixels a side.

        Raises:
            InputError: too few rows for an image, or a scheme without one.
        """
        patterns = plan.image_size**2
        room = max(FEWEST_ROWS, round(_KEPT_SHARE * patterns)) if max_rows is None else max_rows
        if room < FEWEST_ROWS:
            raise InputError(saw=f"max_rows = {room}", expected=f"{FEWEST_ROWS} or more", remedy="leave max_rows out")
        room = min(room, plan.frames, patterns)
        self._plan = plan
        self._patterns = min(plan.frames, patterns)
        one_cycle = plan.model_copy(update={"frames": self._patterns})
        self._scheme = scheme_of(one_cycle)
        rows = image_rows_of(self._scheme)
        columns = self._scheme.columns
        self._after_middle_frames = [columns[k].after_middle_frames for k in (rows.positive, rows.negative)]
        self._pairs = rows.pairs[:room].copy()
        self._frame = np.full(room, -1)  # -1: not yet
        self._values = np.zeros((room, len(columns)))
        self._places_px = np.zeros((room, 2, 2))  # of H+ and H-, x and y
        self._settled_rows = min(room, _SETTLED_SHARE * patterns)
        self._seen = 0
        self._last_px = np.zeros((0, 2))
        self._state: TvState | None = None
        self._spent = 0
        self._direction: Singles | None = None
        self._region = Region.whole(plan.image_size)

    @property
    def frames(self) -> int:
        """Frames seen, those without values too."""
        return self._seen

    @property
    def rows(self) -> int:
        """Frames that the next image uses."""
        return int(np.count_nonzero(self._frame >= 0))

    @property
    def region(self) -> Region:
        """Where the last image may differ from 0."""
        return self._region

    @property
    def misfit(self) -> float:
        """RMS of what the last image leaves unexplained, over the noise; NaN before the first."""
        return self._state.misfit if self._state else float("nan")

    @property
    def nbytes(self) -> int:
        """Memory of what is kept between bursts."""
        kept = sum(array.nbytes for array in (self._pairs, self._frame, self._values, self._places_px))
        if self._state is None or self._direction is None:
            return kept
        return kept + self._state.image.nbytes + self._state.dual.nbytes + self._direction.nbytes

    def add(self, values: Floats, displacement_px: Floats) -> None:
        """Take the next frames; those that were not measured (NaN) only count.

        Args:
            values: ``(n, patterns_per_frame)`` in play order.
            displacement_px: ``(n, 2)`` x, y in the middle of each frame, relative to frame 0, as ``StreamingTracker`` gives it.

        Raises:
            InputError: other shapes.
        """
        patterns = self._values.shape[1]
        if values.shape != (len(values), patterns) or displacement_px.shape != (len(values), 2):
            raise InputError(
                saw=f"values of shape {values.shape} and displacements of shape {displacement_px.shape}",
                expected=f"(n, {patterns}) and (n, 2)",
                remedy="add whole frames, with one displacement each",
            )
        if not len(values):
            return
        velocity_px = self._velocity(displacement_px)
        frame = self._seen + np.arange(len(values))
        self._seen += len(values)
        usable = np.isfinite(values).all(axis=1) & np.isfinite(displacement_px).all(axis=1)
        good = np.flatnonzero(usable & (frame % self._patterns < len(self._frame)))
        here = frame[good] % self._patterns
        self._frame[here] = frame[good]
        self._values[here] = values[good]
        for pattern, after_frames in enumerate(self._after_middle_frames):
            self._places_px[here, pattern] = displacement_px[good] + after_frames * velocity_px[good]

    def improve(self, iterations: int | None = None, *, effort: float = 1.0) -> Floats | None:
        """Spend a burst of iterations on the image of all frames kept, from where the last burst ended.

        Few rows are smoothed more. From a twentieth of all patterns on, edges that were found are freed.

        Args:
            iterations: of the solver; None takes 6 to 60, as many as cost about the same for any number of rows.
            effort: makes that cost larger or smaller.

        Returns:
            ``(m, m)``: the object at frame 0, row = y (down), column = x, in values for one lit pixel; None as long as there are
            fewer than 16 frames, or no light.
        """
        share = min(1.0, self.rows / self._settled_rows)
        strength = _STRENGTH[0] + share * (_STRENGTH[1] - _STRENGTH[0])
        return self._burst(strength, iterations, effort, edges_freed=share == 1 and self._state is not None)

    def polish(self) -> Floats | None:
        """Bring the image to its end: a plain burst, short where many went before, and one with the edges freed.

        Returns:
            As ``improve``.
        """
        plain, freed = _POLISH
        plain = max(plain, _FROM_NOTHING - self._spent)
        if self._burst(_STRENGTH[1], plain, edges_freed=False) is None:
            return None
        return self._burst(_STRENGTH[1], freed, edges_freed=True)

    def _burst(
        self, strength: float, iterations: int | None, effort: float = 1.0, *, edges_freed: bool
    ) -> Floats | None:
        if self.rows < FEWEST_ROWS:
            return None
        newest_last = np.argsort(self._frame)[-self.rows :]
        region, inside = self._region_of(self._places_px[newest_last].reshape(-1, 2))
        if not self._values[newest_last].any():
            return None
        rows, values = self._whitened(newest_last, region, steady_object=inside)
        start = self._start(rows, region)
        if start is None:
            return None
        if iterations is None:
            least, most = _BURST_LIMITS
            iterations = min(max(round(effort * _BURST / (rows.shape[0] * rows.shape[1])), least), most)
        self._state = total_variation(
            rows,
            values,
            strength=strength,
            reweightings=int(edges_freed),
            tolerance=_TOLERANCE,
            iterations=iterations,
            start=start,
        )
        self._spent += iterations
        return region.paste(self._state.image.astype(np.float64), self._plan.image_size)

    def _velocity(self, displacement_px: Floats) -> Floats:
        """``(n, 2)`` px a frame: the smaller of the last two steps, 0 where they disagree; so a jump is no velocity."""
        path_px = np.concatenate([self._last_px, displacement_px])
        path_px = np.pad(path_px, ((2 - len(self._last_px), 0), (0, 0)), mode="edge")
        self._last_px = path_px[-2:].copy()
        steps_px = np.diff(path_px, axis=0)
        before, after = steps_px[:-1], steps_px[1:]
        slower: Floats = np.where(np.abs(before) < np.abs(after), before, after)
        return np.where(before * after > 0, slower, 0.0)

    def _region_of(self, places_px: Floats) -> tuple[Region, bool]:
        """Where an object lies that stays inside the field, and whether there is such a place."""
        try:
            return Region.inside(places_px, self._plan.image_size), True
        except InputError:
            return Region.whole(self._plan.image_size), False

    def _whitened(self, newest_last: Integers, region: Region, *, steady_object: bool) -> tuple[Weighted, Singles]:
        """Rows and values of the differences I_H+ - I_H-, over their noise."""
        kept = self._values[newest_last]
        weights = self._scheme.light_weights
        floor = (_LEAST_NOISE * float(np.sqrt(np.mean(np.square(kept))))) ** 2
        variance = max(noise_variance(kept, weights, np.ones(len(kept), np.bool_)), floor)
        lamp = np.ones(len(kept))
        if steady_object:
            total = uniform_filter1d(kept @ weights, _LIGHT_FRAMES, mode="nearest")
            lamp = np.maximum(total / max(float(total.mean()), 1e-30), 1e-3)
        values = ImageValues.of(
            self._scheme,
            frame=self._frame[newest_last],
            pairs=self._pairs[newest_last],
            values=kept,
            variance=np.full_like(kept, variance),
            time_s=np.zeros_like(kept),
            lamp=lamp,
            size=self._plan.image_size,
            photon_counts=False,
        )
        places_px = self._places_px[newest_last]
        if float(np.sqrt(np.mean(np.diff(places_px, axis=1) ** 2))) <= _SAME_PLACE_PX:
            places_px[:] = places_px.mean(axis=1, keepdims=True)
        rows = ShiftedHadamard.differential(values.pairs, places_px[:, 0], places_px[:, 1], values.size, region)
        sigma = values.difference_sigma
        return Weighted(rows, (1 / sigma).astype(np.float32)), (values.difference / sigma).astype(np.float32)

    def _start(self, rows: Operator, region: Region) -> TvState | None:
        """The last burst's end as this one's start, in the new region and with the new rows' eigenvalue; None without light."""
        steps = _POWER_STEPS[self._direction is not None]
        direction = np.random.default_rng(0).random(region.shape).astype(np.float32)
        if self._direction is not None:
            direction = _moved(self._direction, self._region, region)
        eigenvalue = 0.0
        for _ in range(steps):
            direction = direction / np.float32(max(float(np.linalg.norm(direction)), 1e-30))
            direction = rows.rmatvec(rows.matvec(direction.ravel())).reshape(region.shape)
            eigenvalue = _ABOVE * float(np.linalg.norm(direction))
        if eigenvalue <= 0:
            return None
        last = self._state
        image, dual = np.zeros(region.shape, np.float32), np.zeros((2 * CORNERS, *region.shape), np.float32)
        if last is not None:
            image, dual = (_moved(part, self._region, region) for part in (last.image, last.dual))
            dual *= np.float32(last.eigenvalue / eigenvalue)  # which it is kept divided by
        self._direction, self._region = direction, region
        return TvState(image=image, dual=dual, eigenvalue=eigenvalue, misfit=float("nan"), iterations=0)


def _moved(part: Singles, old: Region, new: Region) -> Singles:
    """Cut ``(..., height, width)`` of one region to another, with zeros where they do not overlap."""
    out = np.zeros((*part.shape[:-2], *new.shape), np.float32)
    top, left = max(old.top, new.top), max(old.left, new.left)
    bottom = min(old.top + old.height, new.top + new.height)
    right = min(old.left + old.width, new.left + new.width)
    if bottom > top and right > left:
        inside = part[..., top - old.top : bottom - old.top, left - old.left : right - old.left]
        out[..., top - new.top : bottom - new.top, left - new.left : right - new.left] = inside
    return out
