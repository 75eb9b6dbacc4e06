"""One projection on the bench: what is counted while it is shown."""

import math

import numpy as np

from protocols import Counts, Floats, Truth
from sim_backends.bench.lamp import Ambient
from sim_backends.bench.light import LightPath
from sim_backends.bench.mirrors import lagged, remainder
from sim_backends.bench.motion import Displacement
from sim_backends.bench.noise import measure
from sim_backends.bench.noise_settings import PhotonNoise
from sim_backends.bench.projection import Projection
from sim_backends.bench.pulses import with_spikes
from sim_backends.bench.settings import SceneSettings
from sim_backends.bench.sync import SyncLine, overlap
from sim_backends.bench.view import View, changing
from sim_backends.bench.wiring import wired

_STRETCH = 512
"""Bins that are worked out together, once, when the first of them is asked for."""


class Run:
    """A projection with everything that depends on it alone. Its light is worked out when it is asked for, and never twice."""

    def __init__(
        self,
        settings: SceneSettings,
        *,
        view: View,
        projection: Projection,
        sync: SyncLine,
        displacement: Displacement,
        all_lit: float,
    ) -> None:
        """Get ready.

        Args:
            settings: the ``[scene]`` table.
            view: what is before the modulator.
            projection: what the modulator shows.
            sync: its edges.
            displacement: how the object moves, by what is known whenever it is asked.
            all_lit: light of the object in an all-lit picture; 0 where nothing is measured by it.
        """
        self.projection = projection
        self.sync = sync
        self.edge_s = projection.start_s + sync.phase * projection.picture_time_s
        """``(edges,)`` times of the seen edges on the bench's clock; not to be written."""
        self.edge_s.flags.writeable = False
        self._settings = settings
        self._view = view
        self._displacement = displacement
        self._scene = changing(view.object, settings, projection.duration_s)
        self._path = LightPath(self._scene, view.optics, view.grid, projection.mirrors)
        self._order = wired(projection.play_order, settings.swap, settings.patterns_late)
        ambient_per_s = settings.ambient_level * all_lit / projection.picture_time_s
        self._ambient = Ambient(ambient_per_s, settings.ambient_ripple, 2 * settings.mains_hz)
        self._counts_per_light = 1.0
        if isinstance(noise := settings.noise, PhotonNoise):
            pictures = 1.0 if noise.peak_in_s is None else projection.picture_time_s / noise.peak_in_s
            self._counts_per_light = noise.peak_counts * pictures / all_lit
        self._remainder = remainder(settings.mirror_transition_s, settings.mirror_settling_s, projection.picture_time_s)
        self._counts = no_counts(settings, max(0, len(self.edge_s) - 1))
        self._known: set[int] = set()

    def at_px(self, time_s: Floats) -> Floats:
        """``(n, 2)`` displacement ``time_s`` (n,) after the first sync edge."""
        return self._displacement.at(self.projection.first_edge_s, time_s)

    def forget_after(self, now_s: float) -> None:
        """Drop what was worked out ahead of time: the object moves otherwise now."""
        whole = int(np.searchsorted(self.edge_s, now_s)) // _STRETCH
        self._known.intersection_update(range(whole))

    def counts(self, first: int, n: int) -> Counts:
        """``(n,)``: what is counted in bin ``first`` and those after it. There must be so many."""
        for stretch in range(first // _STRETCH, -(-(first + n) // _STRETCH)):
            if stretch not in self._known:
                self._count(stretch)
        return self._counts[first : first + n].copy()

    def _count(self, stretch: int) -> None:
        """Work out the bins of one stretch."""
        settings, picture_s = self._settings, self.projection.picture_time_s
        bins = slice(stretch * _STRETCH, (stretch + 1) * _STRETCH)
        begin, end = self.sync.phase[:-1][bins], self.sync.phase[1:][bins]
        light, lit_px, first = self._pictures(begin, end)
        values = measure(
            settings.noise,
            stretch,
            light=self._with_ambient(begin, end, overlap(begin, end, first, light)),
            lit_px=overlap(begin, end, first, lit_px),
            duration_s=(end - begin) * picture_s,
            counts_per_light=self._counts_per_light,
            light_before=float(overlap(begin[:1] - 1, begin[:1], first, light)[0]),
        )
        if settings.spike_probability:
            seed = [getattr(settings.noise, "seed", 0), stretch]
            values = with_spikes(values, settings.spike_probability, settings.spike_factor, seed)
        self._counts[bins] = values
        self._known.add(stretch)

    def _with_ambient(self, begin: Floats, end: Floats, light: Floats) -> Floats:
        """Add what comes past the modulator between ``begin`` and ``end``, which are in picture times."""
        if not self._ambient.level_per_s:
            return light
        picture_s, delay_s = self.projection.picture_time_s, self.projection.sync_delay_s
        return light + self._ambient.light(begin * picture_s + delay_s, end * picture_s + delay_s)

    def _pictures(self, begin: Floats, end: Floats) -> tuple[Floats, Floats, int]:
        """Light and lit area of each picture that the bins touch, and which is the first of them."""
        projection = self.projection
        # One more before the first, from which the mirrors may still be swinging.
        first = max(0, math.floor(begin[0]) - 1)
        picture = np.arange(first, min(len(self._order), math.ceil(end[-1])))
        middle_s = (picture.astype(np.float64) + 0.5) * projection.picture_time_s + projection.sync_delay_s
        seen = self._path.of(self._order[picture], self.at_px(middle_s), middle_s)
        return lagged(seen.light, self._remainder), seen.lit_px, first

    def truth(self, time_s: Floats) -> Truth:
        """What really was there ``time_s`` (n,) after the first sync edge; see ``protocols.Truth``."""
        at_px = self.at_px(time_s)
        image = self._scene.on_grid(float(time_s[0]), at_px[0], self._view.grid.image_size)
        return Truth(at_px - at_px[0], image * self._settings.object_level, self._view.background())


def no_counts(settings: SceneSettings, bins: int) -> Counts:
    """``(bins,)`` zeros of the type that the noise gives."""
    return np.zeros(bins, np.uint32) if isinstance(settings.noise, PhotonNoise) else np.zeros(bins)
