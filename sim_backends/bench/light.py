"""The light that each picture lets through."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np

from protocols import Bytes, Floats, Integers, PixelGrid
from sim_backends.bench.illumination import illumination
from sim_backends.bench.image import AreaImage, Window
from sim_backends.bench.lamp import Lamp
from sim_backends.bench.planes import lit_samples
from sim_backends.bench.pose import ChangingImage

_BATCH = 32_000
"""Samples to work out together: few enough to stay in the processor's cache."""


@dataclass(frozen=True)
class Optics:
    """What the lamp, the background and the mirrors do to the light."""

    lamp: Lamp = field(default_factory=Lamp)
    illumination_falloff: float = 0.0
    edge_loss: float = 0.0
    mirrors_inverted: bool = False
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
        scene: ChangingImage,
        optics: Optics,
        grid: PixelGrid,
        mirrors: Callable[[int], Bytes],
    ) -> None:
        self._scene = scene
        self._optics = optics
        self._grid = grid
        self._mirrors = mirrors
        self._planes: dict[int, _Plane] = {}
        sides, falloff = (grid.image_size, grid.side_mirrors), optics.illumination_falloff
        self._profiles = {side: illumination(side, falloff) for side in sides} if falloff else {}
        self._still: dict[int, tuple[Window, Floats]] = {}

    def of(self, plane_index: Integers, at_px: Floats, time_s: Floats) -> PictureLight:
        """Light of pictures that show ``plane_index`` (n,) while the object is displaced by ``at_px`` (n, 2).

        ``time_s`` (n,) counts from the first sync edge, for what changes with time.
        """
        planes = [self._plane(int(index)) for index in plane_index]
        light = np.array([plane.background for plane in planes])
        samples = np.array([plane.samples for plane in planes])
        scale = self._scene.scale(time_s)
        for posed, image in self._scene.poses(time_s):
            for size in (self._grid.image_size, self._grid.side_mirrors):
                same: Integers = posed[samples[posed] == size]
                if not len(same):
                    continue
                if scale is None and (at_px[same] == at_px[same[0]]).all():  # at rest: each plane has one light
                    shown, again = np.unique(plane_index[same], return_inverse=True)
                    packed = [self._plane(int(index)).packed for index in shown]
                    seen = self._seen(packed, at_px[same[:1]], image)[again]
                else:
                    packed = [planes[int(picture)].packed for picture in same]
                    seen = self._seen(packed, at_px[same], image, None if scale is None else scale[same])
                light[same] += seen * self._optics.object_level
        lamp = self._optics.lamp.brightness(time_s)
        return PictureLight(light * lamp, np.array([plane.lit_px for plane in planes]))

    def _seen(self, packed: Sequence[Bytes], at_px: Floats, scene: AreaImage, scale: Floats | None = None) -> Floats:
        """``(n,)``: light of ``scene``, displaced by ``at_px`` (n, 2), or (1, 2) for all, through planes of one size."""
        light, samples = np.zeros(len(packed)), len(packed[0])
        sample_px = self._grid.image_size / samples
        window = scene.window(at_px, samples, sample_px, scale)
        if window.empty:
            return light
        together = max(
            1, _BATCH // ((window.bottom - window.top) * max(window.right - window.left, scene.cells.shape[1]))
        )
        resting = self._lit(scene, at_px, window, samples, scale) if len(at_px) == 1 else None
        for first in range(0, len(packed), together):
            batch = slice(first, first + together)
            lit = resting
            if lit is None:
                lit = self._lit(scene, at_px[batch], window, samples, None if scale is None else scale[batch])
            passed = lit * self._transmission(packed[batch], window)
            # Not a BLAS product: its order of summation, and so the last bit, depends on the number of threads.
            light[batch] = passed.sum(axis=(1, 2))
        return light

    def _lit(
        self, scene: AreaImage, at_px: Floats, window: Window, samples: int, scale: Floats | None = None
    ) -> Floats:
        """``(n, bottom - top, right - left)``: light that falls on the mirrors."""
        light, profile = scene.light(at_px, window, self._grid.image_size / samples, scale), self._profiles.get(samples)
        if profile is not None:
            light *= profile[window.top : window.bottom, window.left : window.right]
        return light

    def _background(self, packed: Bytes) -> float:
        """Light of the background through a plane. What falls on the mirrors is always the same."""
        image, samples, still_px = self._optics.background, len(packed), np.zeros((1, 2))
        if image is None:
            return 0.0
        if samples not in self._still:
            window = image.window(still_px, samples, self._grid.image_size / samples)
            self._still[samples] = window, self._lit(image, still_px, window, samples)
        window, lit = self._still[samples]
        passed = lit * self._transmission([packed], window)
        return float(passed.sum(axis=(1, 2))[0]) * self._optics.background_level

    def _transmission(self, packed: Sequence[Bytes], window: Window) -> Bytes | Floats:
        """``(n, bottom - top, right - left)``: 0 or 1, less where light is lost at edges."""
        samples = len(packed[0])
        if self._optics.edge_loss == 0:
            rows = np.stack([plane[window.top : window.bottom] for plane in packed])
            return np.unpackbits(rows, axis=2, count=samples)[:, :, window.left : window.right]
        # Beyond the field all mirrors are off.
        mirrors = np.full((len(packed), samples + 2, samples + 2), int(self._optics.mirrors_inverted), np.uint8)
        mirrors[:, 1:-1, 1:-1] = np.unpackbits(np.stack(packed), axis=2, count=samples)
        near = mirrors[:, window.top : window.bottom + 2, window.left : window.right + 2]
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
        lit = lit_samples(packed_mirrors, grid, inverted=optics.mirrors_inverted)
        packed = np.packbits(lit, axis=1)
        return _Plane(packed, int(lit.sum()) * (grid.image_size / len(lit)) ** 2, self._background(packed))
