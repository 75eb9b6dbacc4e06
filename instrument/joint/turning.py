"""Path, angle and image of an object that turns, found together.

Each refinement solves for the image with the pose held (total variation of rows that are written out), and then makes one
Gauss-Newton step of x, y and angle in turn with the image held, each smoothed over the whole run as far as the values ask for it.
The Hadamard values alone decide: moments of second order are noisier by far, and their dithering is off by degrees; they are
where the search begins.
"""

from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.polynomial.legendre import legvander

from instrument.measurement import ImageValues, Measurement
from instrument.numerics import TvState, one_blas_thread, smooth, total_variation
from instrument.reconstruction import DenseRows, Field, Reconstruction, Region, TurnedRows, field_in
from instrument.tracking import Trajectory
from protocols import Floats, InputError, Singles

_FEWEST_FRAMES: Final = 64
_MOST_REFINEMENTS: Final = 16
_STANDS_STILL: Final = 0.2
"""Change of the pose over its uncertainty, both rms, below which it is taken as found."""

_LIT: Final = 0.15
"""Part of the brightest pixel from which on a pixel is the object's, while path and angle are refined,"""

_MARGIN_PX: Final = 6
"""with as many pixels around."""

_LEAST_INFORMATION: Final = 1e-3
_HIGHEST_DEGREE: Final = 4
"""Of a polynomial that may stand for a path or a turn."""

_SMALLEST_PX: Final = 8


@dataclass(frozen=True, eq=False)
class RefinedTurn:
    """Path, angle and image of an object that turns."""

    trajectory: Trajectory
    """The path of the centroid, and the angle."""

    image: Reconstruction
    """Image at frame 0."""

    refinements: int
    """Number of refinements of the pose; 0 where the one given was kept."""


@dataclass(frozen=True, eq=False)
class _Pose:
    """Where the object is in every frame, and how it is turned."""

    place: Floats
    """``(frames, 3)``: displacement x, y in px and angle in radians since frame 0."""

    sigma: Floats
    """``(frames, 3)``: standard deviations."""


@one_blas_thread()
def refine_turn(measurement: Measurement, trajectory: Trajectory, *, refined: bool = True) -> RefinedTurn:
    """Refine the path and the angle of an object that turns, and reconstruct its image at frame 0.

    Args:
        measurement: what was measured with a scheme that sees position, angle and image.
        trajectory: path of the centroid with its position at frame 0, and the angle, from where the search begins.
        refined: whether path and angle are refined; if not, the image is that of the ones given.

    Raises:
        InputError: the trajectory has no angle, or the object does not stay inside the field.
    """
    if trajectory.angle_deg is None or trajectory.angle_sigma_deg is None or trajectory.start_px is None:
        raise InputError(
            saw="a trajectory without an angle",
            expected="one that track() found in a recording of a scheme that sees the angle",
            remedy='record with the scheme "moment-rotation"',
        )
    values = measurement.image_values(steady_object=True)
    field = Field(values.size, 1, measurement.edge_loss_a_side)
    angle = np.stack([trajectory.angle_deg, trajectory.angle_sigma_deg])
    pose = _Pose(
        np.column_stack([trajectory.displacement_px, np.deg2rad(angle[0])]),
        np.column_stack([trajectory.sigma_px, np.deg2rad(angle[1])]),
    )
    pivot_px = np.asarray(trajectory.start_px, np.float64)
    count, state = 0, None
    if refined and len(values) >= _FEWEST_FRAMES:
        pose, count = _refined(values, field, pose, pivot_px)
    rows = _rows(values, field, pose, pivot_px)
    state = _image(values, rows, tolerance=0.1, iterations=40)
    rows = replace(rows, region=_lit(rows.region, state.image, 0.05, 2 * _MARGIN_PX))
    state = _image(values, rows)
    found = replace(
        trajectory,
        displacement_px=pose.place[:, :2],
        sigma_px=pose.sigma[:, :2],
        angle_deg=np.rad2deg(pose.place[:, 2]),
        angle_sigma_deg=np.rad2deg(pose.sigma[:, 2]),
        method="joint" if count else trajectory.method,
    )
    return RefinedTurn(found, _reconstruction(values, rows.region, state), count)


def _refined(values: ImageValues, field: Field, given: _Pose, pivot_px: Floats) -> tuple[_Pose, int]:
    """Refine until the pose stands still."""
    pose = given
    rows = _rows(values, field, pose, pivot_px)
    state = _image(values, rows, tolerance=0.1, iterations=40)
    region = _lit(rows.region, state.image)
    count = 0
    while count < _MOST_REFINEMENTS:
        count += 1
        rows = _rows(values, field, pose, pivot_px, region)
        start = state if count > 1 else None
        state = _image(values, rows, start, tolerance=0.05, iterations=40)
        stepped = _stepped(values, rows, state, pose)
        change = stepped.place - pose.place
        pose = stepped
        if (np.mean(change**2, axis=0) < _STANDS_STILL**2 * np.mean(stepped.sigma**2, axis=0)).all():
            break
    return pose, count


def _lit(region: Region, image: Singles, part: float = _LIT, margin_px: int = _MARGIN_PX) -> Region:
    """Give the rectangle around what an image shows, with a margin: nothing else is looked at."""
    lit = image > part * image.max()
    rows, columns = np.flatnonzero(lit.any(axis=1)), np.flatnonzero(lit.any(axis=0))
    if not len(rows):
        return region
    top, left = max(0, int(rows[0]) - margin_px), max(0, int(columns[0]) - margin_px)
    bottom = min(region.height, int(rows[-1]) + 1 + margin_px)
    right = min(region.width, int(columns[-1]) + 1 + margin_px)
    return Region(region.top + top, region.left + left, bottom - top, right - left)


def _rows(values: ImageValues, field: Field, pose: _Pose, pivot_px: Floats, region: Region | None = None) -> TurnedRows:
    """Prepare the rows of the valid frames, both patterns of a pair at their common middle."""
    frame = values.frame + (values.time_s[:, :2].mean(axis=1) - _middle_s(values)) / _frame_s(values)
    index = np.arange(len(pose.place))
    series: list[Floats] = [np.asarray(np.interp(frame, index, pose.place[:, k]), np.float64) for k in range(3)]
    at: Floats = np.stack(series, axis=1)
    not_grown = np.zeros((len(at), 1))
    return TurnedRows(
        field, values.pairs, np.hstack([at, not_grown]), pivot_px, region or _region(pose, pivot_px, field.size)
    )


def _frame_s(values: ImageValues) -> float:
    """Time from one frame to the next."""
    return float((values.time_s[-1, 0] - values.time_s[0, 0]) / max(1, values.frame[-1] - values.frame[0]))


def _middle_s(values: ImageValues) -> Floats:
    """Middle of each valid frame."""
    return np.asarray((values.frame + 0.5) * _frame_s(values), np.float64)


def _region(pose: _Pose, pivot_px: Floats, size: int) -> Region:
    """Give the rectangle around all pixels that stay inside the field however the object moves and turns.

    Raises:
        InputError: there are none.
    """
    rows, columns = np.mgrid[:size, :size]
    u, v = columns - pivot_px[0], rows - pivot_px[1]
    inside = np.ones((size, size), np.bool_)
    for dx, dy, angle in pose.place[:: max(1, len(pose.place) // 64)]:
        x = pivot_px[0] + dx + u * np.cos(angle) - v * np.sin(angle)
        y = pivot_px[1] + dy + u * np.sin(angle) + v * np.cos(angle)
        inside &= (x > -1) & (x < size) & (y > -1) & (y < size)
    tall, wide = np.flatnonzero(inside.any(axis=1)), np.flatnonzero(inside.any(axis=0))
    if min(len(tall), len(wide)) < _SMALLEST_PX:
        raise InputError(
            saw=f"a path and turn that leave {len(wide)} x {len(tall)} px of a field of {size} px inside all the time",
            expected="an object that stays inside the field all the time",
            remedy="keep the object inside the field, or record fewer frames",
        )
    top, left = int(tall[0]), int(wide[0])
    return Region(top, left, int(tall[-1]) + 1 - top, int(wide[-1]) + 1 - left)


def _image(
    values: ImageValues,
    rows: TurnedRows,
    start: TvState | None = None,
    *,
    tolerance: float = 0.005,
    iterations: int = 400,
) -> TvState:
    """Solve for the image with the pose held."""
    sigma = values.difference_sigma
    matrix = rows.matrix() / sigma.astype(np.float32)[:, None]
    operator = DenseRows(matrix, rows.region.shape)
    whitened = (values.difference / sigma).astype(np.float32)
    return total_variation(operator, whitened, tolerance=tolerance, iterations=iterations, start=start)


def _stepped(values: ImageValues, rows: TurnedRows, state: TvState, last: _Pose) -> _Pose:
    """Make one Gauss-Newton step for x, with that made one for y, and then one for the angle."""
    predicted, slopes = rows.values(state.image)
    sigma, frame = values.difference_sigma, values.frame
    residual, slopes = (values.difference - predicted) / sigma, slopes / sigma[:, None]
    place, variance = last.place.copy(), np.zeros_like(last.place)
    for k in (0, 1, 2):
        information, score = np.zeros(len(place)), np.zeros(len(place))
        information[frame], score[frame] = slopes[:, k] ** 2, slopes[:, k] * residual
        floor = _LEAST_INFORMATION * information.max()
        target = last.place[:, k] + score / np.maximum(information, floor)
        place[:, k], variance[:, k] = _smoothed(target, information)
        residual = residual - slopes[:, k] * (place[:, k] - last.place[:, k])[frame]
    return _Pose(_since_frame_0(place), np.sqrt(variance))


def _since_frame_0(place: Floats) -> Floats:
    """Give poses, ``(frames, 3)``, against that of frame 0.

    The object at frame 0 stands at c + p_0 + R_0 (u - c) where its pixel is u in the image. In the image of that place, u', the
    pose p_k + R_k (u - c) is p_k - R p_0 + R (u' - c), with R the turn since frame 0.
    """
    angle = place[:, 2] - place[0, 2]
    x, y = place[0, :2]
    cos, sin = np.cos(angle), np.sin(angle)
    return np.column_stack([place[:, 0] - (x * cos - y * sin), place[:, 1] - (x * sin + y * cos), angle])


def _smoothed(series: Floats, information: Floats) -> tuple[Floats, Floats]:
    """Smooth a series of noisy numbers, and give the variance of its change since the first, both ``(frames,)``.

    Where a polynomial of low degree explains the numbers as well as a spline does for the numbers that each takes (Schwarz's
    criterion), it is taken: a steady motion or turn is known better than one that might do anything.

    References:
        G. Schwarz, Annals of Statistics 6 (1978) 461.
    """
    fit = smooth(series, information, absolute_weights=True)
    price = float(np.log(np.count_nonzero(information)))
    best = float(information @ (series - fit.values) ** 2) + price * fit.degrees_of_freedom
    values, variance = fit.values, fit.variance_to_first
    time = np.linspace(-1.0, 1.0, len(series))
    for degree in range(1, _HIGHEST_DEGREE + 1):
        powers = legvander(time, degree)
        covariance = np.linalg.inv(powers.T @ (information[:, None] * powers))
        found = powers @ (covariance @ (powers.T @ (information * series)))
        score = float(information @ (series - found) ** 2) + price * (degree + 1)
        if score < best:
            since = powers - powers[0]
            best, values, variance = score, found, np.einsum("fp,pq,fq->f", since, covariance, since)
    return values, variance


def _reconstruction(values: ImageValues, region: Region, state: TvState) -> Reconstruction:
    """Place the image in the whole field, and scale it."""
    image = region.paste(state.image.astype(np.float64), values.size)
    gain = float(image.max()) if values.photon_counts and image.max() > 0 else 1.0
    field = field_in(region, values.size)
    return Reconstruction(image / gain, "tv", gain, values.noise, state.misfit, state.iterations, region, field)
