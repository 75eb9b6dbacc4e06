"""Which of the eight ways a known target lies in an image.

Under white noise of standard deviation s, an image I that shows a target t times a brightness has the log-likelihood
(I . t)^2 / (2 s^2 |t|^2) above that of nothing, at the place where it is largest. It is taken over places (by Fourier
transform), heights and small turns of the target in each of its eight ways.
"""

from dataclasses import dataclass
from typing import Final

import numpy as np
from scipy import fft, ndimage

from instrument.config import ORIENTATIONS, Orientation
from protocols import Floats

_SMALLEST_PX: Final = 8.0
_STEP: Final = 1.12
_TURNS_DEG: Final = (-12.0, -6.0, 0.0, 6.0, 12.0)
_FINE_DEG: Final = (-4.0, -2.0, 0.0, 2.0, 4.0)
_FINE: Final = (0.93, 0.965, 1.0, 1.035, 1.07)
_GAUSSIAN_MAD: Final = 1.4826

GRID_PX: Final = 0.15
"""Error of a place, along each axis, of an object that lies otherwise between the pixels than the template."""


@dataclass(frozen=True, eq=False)
class Match:
    """A target found in an image."""

    orientation: Orientation
    """Which way it lies."""

    turn_deg: float
    """Turn beyond that, clockwise."""

    height_px: float
    """Height of the upright target."""

    corner_px: tuple[float, float]
    """Column and row of the upper left corner of ``template``."""

    template: Floats
    """The target as it lies in the image."""

    certainty: float
    """Log-likelihood by which it is better than the best in another way."""

    found: float
    """Log-likelihood by which it is better than no target at all."""


def laid(cells: Floats, orientation: Orientation) -> Floats:
    """Give an upright picture as it lies in an orientation."""
    way = ORIENTATIONS.index(orientation)
    return np.rot90(cells[:, ::-1] if way >= 4 else cells, -(way % 4))


def upright(image: Floats, orientation: Orientation) -> Floats:
    """Turn an image upright that lies in an orientation: the inverse of ``laid``."""
    way = ORIENTATIONS.index(orientation)
    turned = np.rot90(image, way % 4)
    return turned[:, ::-1] if way >= 4 else turned


def match_target(image: Floats, target: Floats, band: float = 1.0) -> Match:
    """Find a target in an image.

    Args:
        image: ``(m, m)``, dark but for the target, noise white.
        target: transmission of the upright target, cut to its border.
        band: share of all Hadamard patterns that the image is made of. Its noise is white within them: of one pixel it is
        less, by
            the root of the share, than of what the image is made of.

    Returns:
        The most likely way, place, height and turn.
    """
    size = len(image)
    noise = _GAUSSIAN_MAD * float(np.median(np.abs(image - np.median(image))))
    shape = (2 * size, 2 * size)
    spectrum = np.conj(fft.rfft2(image, shape))

    def score(way: Orientation, height: float, turn_deg: float) -> tuple[float, Floats, tuple[int, int]]:
        template = _template(laid(target, way), height * _stretch(target, way), turn_deg)
        if max(template.shape) > size:
            return 0.0, template, (0, 0)
        overlap = fft.irfft2(np.conj(spectrum) * np.conj(fft.rfft2(template, shape)), shape)
        best = np.unravel_index(int(np.argmax(overlap)), shape)
        row, column = (int(k) if k < size else int(k) - 2 * size for k in best)
        power = max(float(overlap[best]), 0.0) ** 2 / float((template**2).sum())
        return power, template, (column, row)

    heights = [_SMALLEST_PX * _STEP**k for k in range(int(np.log(size / _SMALLEST_PX) / np.log(_STEP)) + 1)]
    coarse: dict[Orientation, tuple[float, float, float]] = {}
    for way in ORIENTATIONS:
        tries = ((score(way, height, turn)[0], height, turn) for height in heights for turn in _TURNS_DEG)
        coarse[way] = max(tries)
    fine: dict[Orientation, tuple[float, float, float]] = {}
    for way, (_, height, turn) in coarse.items():
        tries = (
            (score(way, height * scale, turn + more)[0], height * scale, turn + more)
            for scale in _FINE
            for more in _FINE_DEG
        )
        fine[way] = max(tries)
    order = sorted(ORIENTATIONS, key=lambda way: -fine[way][0])
    best = order[0]
    power, height, turn = fine[best]
    _, template, corner = score(best, height, turn)
    unit = 2 * max(noise, 1e-12) ** 2 / band
    return Match(
        best,
        turn,
        height,
        (float(corner[0]), float(corner[1])),
        template,
        (power - fine[order[1]][0]) / unit,
        power / unit,
    )


def place_of(image: Floats, template: Floats, band: float = 1.0) -> tuple[Floats, Floats]:
    """Find a template in an image to a fraction of a pixel.

    Args:
        image: ``(m, m)``, noise white.
        template: what was found in another image of the same thing.
        band: as for ``match_target``.

    Returns:
        ``(2,)`` column and row of the template's corner, and the standard deviation of each, with ``GRID_PX`` for a template that
        lies otherwise between the pixels.
    """
    size = len(image)
    shape = (2 * size, 2 * size)
    overlap = np.roll(fft.irfft2(fft.rfft2(image, shape) * np.conj(fft.rfft2(template, shape)), shape), size, (0, 1))
    inner = overlap[1:-1, 1:-1]
    row, column = (int(k) + 1 for k in np.unravel_index(int(np.argmax(inner)), inner.shape))
    peak = overlap[row, column]
    place: list[float] = []
    sigma: list[float] = []
    noise = _GAUSSIAN_MAD * float(np.median(np.abs(image - np.median(image)))) / band**0.5
    brightness = float(peak) / float((template**2).sum())
    for axis, at, low, high in (
        (1, column, overlap[row, column - 1], overlap[row, column + 1]),
        (0, row, overlap[row - 1, column], overlap[row + 1, column]),
    ):
        bend = float(low + high - 2 * peak)
        place.append(at - size + float(low - high) / (2 * bend))
        slope = np.gradient(np.pad(template, 1), axis=axis)
        sigma.append(float(np.hypot(noise / max(brightness * np.sqrt((slope**2).sum()), 1e-12), GRID_PX)))
    return np.array(place), np.array(sigma)


def _stretch(target: Floats, way: Orientation) -> float:
    """Height of the target as it lies over its upright height."""
    turned = ORIENTATIONS.index(way) % 2
    return target.shape[1] / target.shape[0] if turned else 1.0


def _template(cells: Floats, height: float, turn_deg: float) -> Floats:
    """Cells on pixels, ``height`` of them high, turned clockwise by a small angle about the middle."""
    zoom = height / len(cells)
    padded = np.pad(cells, max(1, round(1 / zoom)))
    turned = ndimage.rotate(padded, -turn_deg, reshape=turn_deg != 0, order=1) if turn_deg else padded
    wanted = [max(1, round(side * zoom)) for side in turned.shape]
    finer = max(1, int(np.ceil(1 / zoom)))
    return np.asarray(_area_mean(turned, wanted, finer), np.float64)


def _area_mean(cells: Floats, shape: list[int], finer: int) -> Floats:
    """Cells averaged over the pixels of another grid, by sampling each pixel ``finer`` times along each side."""
    rows, columns = (
        np.minimum(((np.arange(wanted * finer) + 0.5) * len_in / (wanted * finer)).astype(int), len_in - 1)
        for wanted, len_in in zip(shape, cells.shape, strict=True)
    )
    sampled = cells[rows][:, columns]
    return np.asarray(sampled.reshape(shape[0], finer, shape[1], finer).mean(axis=(1, 3)), np.float64)
