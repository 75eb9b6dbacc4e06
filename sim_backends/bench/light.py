"""The light that each picture lets through."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from protocols import Bytes, Floats, Integers, PixelGrid
from sim_backends.bench.image import AreaImage, Window

_BATCH = 32_000
"""Samples to work out together: few enough to stay in the processor's cache."""


@dataclass(frozen=True)
class Optics:
    """What the lamp, the background and the mirrors do to the light."""

    level: float = 1.0
    drift_per_s: float = 0.0
    edge_loss: float = 0.0
    background: AreaImage | None = None
    background_level: float = 1.0
    object_level: float = 1.0


@dataclass(frozen=True, eq=False)
class _Plane:
    """A unique plane as the light sees it, on the coarsest grid that loses nothing."""

    packed: Bytes
    """``(samples, ceil(samples / 8))`` pattern, 8 samples a byte."""

    lit_px: float
    """Lit area in image pixels."""

    background: float
    """Light of the background, which stands still."""

    @property
    def samples(self) -> int:
        """Samples a side."""
        return int(self.packed.shape[0])


@dataclass(frozen=True, eq=False)
class PictureLight:
    """Light and lit area of a stretch of pictures."""

    light: Floats
    """``(n,)`` sum of transmission times pattern over the image, times the lamp, for one whole picture time."""

    lit_px: Floats
    """``(n,)`` lit area in image pixels."""


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
        light = np.array([plane.background for plane in planes])
        samples = np.array([plane.samples for plane in planes])
        for size in (self._grid.image_size, self._grid.side_mirrors):
            same = np.flatnonzero(samples == size)
            if len(same):
                seen = self._seen([planes[picture].packed for picture in same], at_px[same], self._scene)
                light[same] += seen * self._optics.object_level
        lamp = self._optics.level * np.maximum(1 + self._optics.drift_per_s * time_s, 0.0)
        return PictureLight(light * lamp, np.array([plane.lit_px for plane in planes]))

    def _seen(self, packed: Sequence[Bytes], at_px: Floats, scene: AreaImage) -> Floats:
        """``(n,)``: light of ``scene``, displaced by ``at_px`` (n, 2), through planes of one size."""
        light, samples = np.zeros(len(packed)), len(packed[0])
        sample_px = self._grid.image_size / samples
        window = scene.window(at_px, samples, sample_px)
        if window.empty:
            return light
        together = max(
            1, _BATCH // ((window.bottom - window.top) * max(window.right - window.left, scene.cells.shape[1]))
        )
        for first in range(0, len(packed), together):
            batch = slice(first, first + together)
            passed = scene.light(at_px[batch], window, sample_px) * self._transmission(packed[batch], window)
            # Not a BLAS product: its order of summation, and so the last bit, depends on the number of threads.
            light[batch] = passed.sum(axis=(1, 2))
        return light

    def _transmission(self, packed: Sequence[Bytes], window: Window) -> Bytes | Floats:
        """``(n, bottom - top, right - left)``: 0 or 1, less where light is lost at edges."""
        samples = len(packed[0])
        if self._optics.edge_loss == 0:
            rows = np.stack([plane[window.top : window.bottom] for plane in packed])
            return np.unpackbits(rows, axis=2, count=samples)[:, :, window.left : window.right]
        field = np.pad(np.unpackbits(np.stack(packed), axis=2, count=samples), ((0, 0), (1, 1), (1, 1)))
        near = field[:, window.top : window.bottom + 2, window.left : window.right + 2].astype(np.float64)
        lit = near[:, 1:-1, 1:-1]
        lit_sides = near[:, :-2, 1:-1] + near[:, 2:, 1:-1] + near[:, 1:-1, :-2] + near[:, 1:-1, 2:]
        # A sample has one row of its mirrors along a side that borders a dark one.
        loss = self._optics.edge_loss * samples / self._grid.side_mirrors
        transmission: Floats = lit * (1 - loss * (4 - lit_sides))
        return transmission

    def _plane(self, index: int) -> _Plane:
        plane = self._planes.get(index)
        if plane is None:
            plane = self._planes[index] = self._take(self._mirrors(index))
        return plane

    def _take(self, packed_mirrors: Bytes) -> _Plane:
        grid, optics = self._grid, self._optics
        coarse = superpixels(packed_mirrors, grid)
        lit = field_mirrors(packed_mirrors, grid) if coarse is None else coarse
        packed = np.packbits(lit, axis=1)
        background = 0.0
        if optics.background is not None:
            background = float(self._seen([packed], np.zeros((1, 2)), optics.background)[0]) * optics.background_level
        lit_samples = int(np.bitwise_count(packed).sum())
        return _Plane(packed, lit_samples * (grid.image_size / len(lit)) ** 2, background)


def superpixels(packed: Bytes, grid: PixelGrid) -> Bytes | None:
    """One mirror of each superpixel, ``(image_size, image_size)``; None where a superpixel is not of one piece.

    On the image grid the light is the same as on the mirrors, and it is found faster.
    """
    size, side = grid.superpixel, grid.side_mirrors
    field, left = _field(packed, grid)
    rows = field[::size]
    if not all((field[mirror::size] == rows).all() for mirror in range(1, size)):
        return None
    mirrors = np.unpackbits(rows, axis=1)[:, left : left + side]
    first = np.ascontiguousarray(mirrors[:, ::size])
    return first if all((mirrors[:, mirror::size] == first).all() for mirror in range(1, size)) else None


def field_mirrors(packed: Bytes, grid: PixelGrid) -> Bytes:
    """Cut the image field out of a packed mirror plane: ``(side_mirrors, side_mirrors)`` of 0 and 1."""
    field, left = _field(packed, grid)
    return np.unpackbits(field, axis=1)[:, left : left + grid.side_mirrors]


def _field(packed: Bytes, grid: PixelGrid) -> tuple[Bytes, int]:
    """The bytes that hold the field, and in which bit of the first of them it begins."""
    (top, left), side = grid.origin, grid.side_mirrors
    return packed[top : top + side, left // 8 : -(-(left + side) // 8)], left % 8
