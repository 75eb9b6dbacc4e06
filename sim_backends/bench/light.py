"""The light that each picture lets through."""

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from protocols import Bytes, Floats, Integers, PixelGrid
from sim_backends.bench.image import AreaImage, Window


@dataclass(frozen=True)
class Optics:
    """What the lamp, the background and the mirrors do to the light."""

    level: float = 1.0
    drift_per_s: float = 0.0
    edge_loss: float = 0.0
    background: AreaImage | None = None
    background_level: float = 1.0


@dataclass(frozen=True, eq=False)
class _Plane:
    """A unique plane as the light sees it, on the coarsest grid that loses nothing."""

    packed: Bytes
    samples: int
    sample_px: float
    loss: float
    lit_px: float
    background: float

    def transmission(self, window: Window) -> Floats | Bytes:
        """``(bottom - top, right - left)``: 0 or 1, less where light is lost at edges."""
        lit = np.unpackbits(self.packed[window.top : window.bottom], axis=1, count=self.samples)
        lit = lit[:, window.left : window.right]
        return lit if self.loss == 0 else lit - self.loss * self._dark_sides(window)

    def _dark_sides(self, window: Window) -> Floats:
        """Sides of each lit sample that border a dark one (0 for a dark sample)."""
        field = np.pad(np.unpackbits(self.packed, axis=1, count=self.samples), 1).astype(np.float64)
        rows, columns = slice(window.top, window.bottom + 2), slice(window.left, window.right + 2)
        near = field[rows, columns]
        lit_sides = near[:-2, 1:-1] + near[2:, 1:-1] + near[1:-1, :-2] + near[1:-1, 2:]
        sides: Floats = near[1:-1, 1:-1] * (4 - lit_sides)
        return sides


@dataclass(frozen=True, eq=False)
class PictureLight:
    """Light and lit area of a stretch of pictures."""

    light: Floats
    """``(n,)``: sum of transmission times pattern over the image, times the lamp, for one whole picture time."""

    lit_px: Floats
    """``(n,)``: lit area in image pixels."""


class LightPath:
    """From the pictures of one projection to their light. Planes are fetched once, when first shown."""

    def __init__(
        self,
        scene: AreaImage,
        optics: Optics,
        grid: PixelGrid,
        mirrors: Callable[[int], Bytes],
    ) -> None:
        self._scene = scene
        self._optics = optics
        self._grid = grid
        self._mirrors = mirrors
        self._planes: dict[int, _Plane] = {}

    def of(self, plane_index: Integers, at_px: Floats, time_s: Floats) -> PictureLight:
        """Light of pictures that show ``plane_index`` (n,) while the object is displaced by ``at_px`` (n, 2).

        ``time_s`` (n,) counts from the first sync edge, for the lamp's drift.
        """
        planes = [self._plane(int(index)) for index in plane_index]
        light = np.array([self._seen(plane, dx, dy) for plane, (dx, dy) in zip(planes, at_px.tolist(), strict=True)])
        lamp = self._optics.level * (1 + self._optics.drift_per_s * time_s)
        return PictureLight(light * lamp, np.array([plane.lit_px for plane in planes]))

    def _seen(self, plane: _Plane, dx_px: float, dy_px: float) -> float:
        window = self._scene.window(dx_px, dy_px, plane.samples, plane.sample_px)
        if window.empty:
            return plane.background
        scene = self._scene.light(dx_px, dy_px, window, plane.sample_px)
        # Not a BLAS product: its order of summation, and so the last bit, depends on the number of threads.
        return float((scene * plane.transmission(window)).sum()) + plane.background

    def _plane(self, index: int) -> _Plane:
        plane = self._planes.get(index)
        if plane is None:
            plane = self._planes[index] = self._take(self._mirrors(index))
        return plane

    def _take(self, packed_mirrors: Bytes) -> _Plane:
        grid, optics = self._grid, self._optics
        field = field_mirrors(packed_mirrors, grid)
        size = grid.superpixel
        blocks = field.reshape(grid.image_size, size, grid.image_size, size)
        coarse = np.ascontiguousarray(blocks[:, 0, :, 0])
        whole = bool((blocks == coarse[:, None, :, None]).all())
        samples = grid.image_size if whole else grid.side_mirrors
        sample_px = grid.image_size / samples
        # A superpixel has one row of `size` mirrors, of its size^2, along a side that borders a dark one.
        loss = optics.edge_loss / (size if whole else 1)
        packed = np.packbits(coarse if whole else field, axis=1)
        plane = _Plane(packed, samples, sample_px, loss, float(field.sum()) / size**2, 0.0)
        if optics.background is None:
            return plane
        still = optics.background.on_grid(0.0, 0.0, samples, sample_px)
        seen = float((still * plane.transmission(Window(0, samples, 0, samples))).sum()) * optics.background_level
        return _Plane(packed, samples, sample_px, loss, plane.lit_px, seen)


def field_mirrors(packed: Bytes, grid: PixelGrid) -> Bytes:
    """Cut the image field out of a packed mirror plane: ``(side_mirrors, side_mirrors)`` of 0 and 1."""
    top, left = grid.origin
    side = grid.side_mirrors
    first = left // 8
    rows = np.unpackbits(packed[top : top + side, first : -(-(left + side) // 8)], axis=1)
    return rows[:, left - 8 * first : left - 8 * first + side]
