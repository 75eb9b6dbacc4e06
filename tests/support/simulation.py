"""A run computed straight from the formulas: an oracle for tracking and reconstruction that shares no code with the bench.

The object is made of square pixels, so a sub-pixel shift is linear interpolation, exactly. A value is the correlation of
pattern and object, read at the displacement: a product of two shifted Walsh rows for a Hadamard pattern, a map for a Fourier
pattern. ``shifted`` and a sum over pixels give the same, slowly.
"""

from collections.abc import Callable

import numpy as np

from instrument.patterns import walsh_matrix
from instrument.plan import Plan
from instrument.recording import Recording
from instrument.schemes import Scheme, scheme_of
from protocols import Floats, Integers, Truth

Path2D = Callable[[Floats], Floats]
"""Seconds ``(n,)`` to displacement ``(n, 2)`` in x, y pixels."""


def shifted(image: Floats, dx: float, dy: float) -> Floats:
    """Move an image by (dx, dy) px, zero from outside: O(x - dx, y - dy)."""
    size = len(image)
    dx, dy = (min(max(d, -size - 1.0), size + 1.0) for d in (dx, dy))  # farther away there is nothing left to see
    ix, iy = int(np.floor(dx)), int(np.floor(dy))
    fx, fy = dx - ix, dy - iy
    pad = size + 2
    wide = np.zeros((size + 2 * pad, size + 2 * pad))
    wide[pad : pad + size, pad : pad + size] = image

    def cut(oy: int, ox: int) -> Floats:
        return wide[pad - iy - oy : pad - iy - oy + size, pad - ix - ox : pad - ix - ox + size]

    return (1 - fy) * ((1 - fx) * cut(0, 0) + fx * cut(0, 1)) + fy * ((1 - fx) * cut(1, 0) + fx * cut(1, 1))


def simulate(
    plan: Plan,
    image: Floats,
    path: Path2D,
    *,
    sigma: float = 0.0,
    peak_counts: float | None = None,
    light: Callable[[Floats], Floats] | None = None,
    seed: int = 0,
) -> Recording:
    """Record ``image`` moved along ``path``, each pattern at its own time.

    Args:
        plan: what is shown.
        image: ``(m, m)`` transmission at displacement 0.
        path: displacement over time; the truth is stated relative to frame 0's middle.
        sigma: ``pixel`` noise: sigma * sqrt(lit pixels) on every value.
        peak_counts: photon counting instead: counts of an all-on pattern.
        light: brightness of the lamp over time; None for 1.
        seed: of the noise.
    """
    scheme, per_frame = scheme_of(plan), plan.patterns_per_frame
    time_s = (np.arange(plan.patterns, dtype=np.float64) + 0.5) * plan.picture_time_s
    places = path(time_s).reshape(plan.frames, per_frame, 2)
    values, lit = _noise_free(plan, scheme, image, places)
    if light is not None:
        values *= light(time_s).reshape(values.shape)
    rng = np.random.default_rng(seed)
    if peak_counts is not None:
        values[:] = rng.poisson(np.maximum(values, 0) * peak_counts / image.sum())
    elif sigma:
        values += rng.normal(size=values.shape) * sigma * np.sqrt(lit)
    middle = path((np.arange(plan.frames, dtype=np.float64) + 0.5) * plan.frame_time_s)
    start = path(np.array([plan.frame_time_s / 2]))[0]
    return Recording(
        plan=plan,
        values=values,
        frame_valid=np.ones(plan.frames, np.bool_),
        picture_time_s=plan.picture_time_s,
        photon_counts=peak_counts is not None,
        truth=Truth(displacement_px=middle - start, image=shifted(image, float(start[0]), float(start[1]))),
    )


def _noise_free(plan: Plan, scheme: Scheme, image: Floats, places: Floats) -> tuple[Floats, Floats]:
    """Values and lit pixels of each pattern, both ``(frames, patterns)``, for displacements ``(frames, patterns, 2)``."""
    size = plan.image_size
    values, lit = np.empty(places.shape[:2]), np.empty(places.shape[:2])
    fixed = [k for k, column in enumerate(scheme.columns) if column.role != "hadamard"]
    for k, samples in zip(fixed, scheme.fixed_patterns, strict=True):
        scale = len(samples) // size
        pattern = samples.reshape(size, scale, size, scale).mean(axis=(1, 3))
        values[:, k] = _correlation(pattern, image, places[:, k])
        lit[:, k] = pattern.sum()
    if scheme.image_rows is None:
        return values, lit
    walsh = walsh_matrix(size).astype(np.float64)
    pairs = scheme.image_rows.pairs
    down, across = walsh[pairs[:, 0]], walsh[pairs[:, 1]]
    positive = size * size * (1 + (pairs == 0).all(axis=1)) / 2
    for k, sign in ((k, column.sign) for k, column in enumerate(scheme.columns) if column.role == "hadamard"):
        both = _row_products(np.ones_like(down), np.ones_like(across), image, places[:, k])
        values[:, k] = (both + sign * _row_products(down, across, image, places[:, k])) / 2
        lit[:, k] = positive if sign > 0 else size * size - positive
    return values, lit


def _row_products(down: Floats, across: Floats, image: Floats, place: Floats) -> Floats:
    """Sum of down(y) across(x) O(x - dx, y - dy) over the field, a frame a row."""
    rows = _moved_back(down, place[:, 1])
    columns = _moved_back(across, place[:, 0])
    products: Floats = np.einsum("fx,fx->f", rows @ image, columns)
    return products


def _moved_back(rows: Floats, place: Floats) -> Floats:
    """Each row r(x) as r(x + d), zero from outside, linear between pixels."""
    size: int = rows.shape[1]
    whole = np.floor(place).astype(np.int64)
    wide = np.pad(rows, ((0, 0), (1, 1)))
    frame, column = np.arange(len(rows))[:, None], np.arange(size)

    def at(offset: int) -> Floats:
        index: Integers = np.add.outer(whole, column + (offset + 1))
        inside = (index >= 0) & (index <= size + 1)
        picked: Floats = wide[frame, np.where(inside, index, 0)]
        return picked

    part = (place - whole)[:, None]
    return (1 - part) * at(0) + part * at(1)


def _correlation(pattern: Floats, image: Floats, place: Floats) -> Floats:
    """Sum of P(x, y) O(x - dx, y - dy) over the field at each displacement."""
    size = 2 * len(image)
    spectrum = np.fft.rfft2(pattern, (size, size)) * np.conj(np.fft.rfft2(image, (size, size)))
    chart: Floats = np.fft.irfft2(spectrum, (size, size))
    whole = np.floor(place).astype(np.int64)
    part_x, part_y = place[:, 0] - whole[:, 0], place[:, 1] - whole[:, 1]

    def at(oy: int, ox: int) -> Floats:
        x, y = whole[:, 0] + ox, whole[:, 1] + oy
        inside = (np.abs(x) < len(image)) & (np.abs(y) < len(image))
        picked: Floats = np.where(inside, chart[y % size, x % size], 0.0)
        return picked

    upper = (1 - part_x) * at(0, 0) + part_x * at(0, 1)
    lower = (1 - part_x) * at(1, 0) + part_x * at(1, 1)
    return (1 - part_y) * upper + part_y * lower
