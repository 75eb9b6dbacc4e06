"""How bright the modulator's field is lit."""

from collections.abc import Callable
from typing import Any, Literal

import numpy as np
from pydantic import NonNegativeFloat

from protocols import Floats, Frozen

_CUBIC = 3


class Profile(Frozen):
    """Brightness of the field, which stands still whatever the object does.

    An uneven lamp before the object, the darkening of a lens towards its border, and uneven collection behind the modulator all
    look like this: each mirror's light is multiplied by the brightness of its place.
    """

    values: tuple[tuple[float, ...], ...]
    """Brightness at points that are evenly spaced from the field's first edge to its last, row by row from the top; two or more
    along each axis. 1 is the brightness that an image's transmissions refer to."""

    sigma: NonNegativeFloat | None = None
    """Standard deviation of a value; None where nobody stated one."""

    source: Literal["given", "calibrated"] = "given"
    """Where it comes from."""

    def over(self, pixels: int) -> Floats:
        """Give the brightness in the middle of each of ``pixels`` x ``pixels`` pixels, by a spline of up to third order."""
        grid = np.array(self.values)
        rows, columns = (np.linspace(0, 1, count) for count in grid.shape)
        orders = [min(_CUBIC, count - 1) for count in grid.shape]
        middle = (np.arange(pixels) + 0.5) / pixels
        return np.asarray(_spline(rows, columns, grid, kx=orders[0], ky=orders[1])(middle, middle), np.float64)

    @classmethod
    def of(cls, picture: Floats, points: int = 9, *, sigma: float | None = None) -> "Profile":
        """Reduce a picture of the evenly transmitting field to a calibrated profile, least squares over its pixels.

        Args:
            picture: ``(pixels, pixels)`` brightness of each pixel.
            points: points along each axis, 4 or more.
            sigma: standard deviation of a value, if known.
        """
        pixels = len(picture)
        places, middle = np.linspace(0, 1, points), (np.arange(pixels) + 0.5) / pixels
        weights = np.stack(
            [
                _spline(places, places, np.outer(unit, np.ones(points)), kx=_CUBIC, ky=_CUBIC)(middle, [0.5])[:, 0]
                for unit in np.eye(points)
            ],
            axis=1,
        )
        inverse = np.linalg.pinv(weights)
        values = inverse @ picture @ inverse.T
        return cls(values=tuple(tuple(row) for row in values.tolist()), sigma=sigma, source="calibrated")

    @classmethod
    def of_blocks(cls, light: Floats, sigma: Floats) -> "Profile":
        """Fit a surface of second degree to the light of blocks, by weighted least squares: a lamp and a lens make no more.

        Args:
            light: ``(n, n)`` mean light of each block of the field, relative to their mean; 3 or more along each axis.
            sigma: ``(n, n)`` standard deviation of each.
        """
        blocks = len(light)
        middle = (np.arange(blocks) + 0.5) * 2 / blocks - 1
        spread = 1 / (3 * blocks**2)  # the mean of a square over a block lies above the square of its middle
        terms = _second_degree(middle, middle, spread).reshape(-1, 6)
        weight = 1 / np.maximum(sigma.ravel(), 1e-6)
        fitted, *_ = np.linalg.lstsq(terms * weight[:, None], light.ravel() * weight, rcond=None)
        covariance = np.linalg.inv((terms * weight[:, None] ** 2).T @ terms)
        edges = np.linspace(-1, 1, 3)
        at = _second_degree(edges, edges).reshape(-1, 6)
        values = np.maximum((at @ fitted).reshape(3, 3), 0.01)
        worst = float(np.sqrt(np.max(np.sum(at @ covariance * at, axis=1))))
        return cls(values=tuple(tuple(row) for row in values.tolist()), sigma=worst, source="calibrated")


def _second_degree(rows: Floats, columns: Floats, spread: float = 0.0) -> Floats:
    """``(rows, columns, 6)``: 1, y, x, y^2, x y, x^2 at each place, the squares averaged over a width of variance ``spread``."""
    y, x = np.meshgrid(rows, columns, indexing="ij")
    return np.stack([np.ones_like(x), y, x, y**2 + spread, x * y, x**2 + spread], axis=-1)


def _spline(rows: Floats, columns: Floats, grid: Floats, *, kx: int, ky: int) -> Callable[[Any, Any], Floats]:
    from scipy.interpolate import RectBivariateSpline  # noqa: PLC0415 - slow to load: only uneven light needs it

    return RectBivariateSpline(rows, columns, grid, kx=kx, ky=ky)
