"""The voltages on both inputs, sample by sample, from the light of the bench."""

import numpy as np
from scipy.signal import lfilter

from protocols import Floats
from sim_backends.bench import OpticalBench
from sim_backends.wire.ni_analog.settings import NiAnalogEmulatorSettings

_PATIENCE_S = 0.05
"""Light of a bin is known when it closes; one that is open longer than this is taken to be dark from then on."""


class Signal:
    """Samples from a moment on, each once."""

    def __init__(self, settings: NiAnalogEmulatorSettings, bench: OpticalBench, rate_hz: float) -> None:
        """Begin now."""
        self._settings, self._bench, self._rate_hz = settings, bench, rate_hz
        self._from_s = bench.clock.now_s()
        self._next = 0
        self._noise = np.random.default_rng(settings.seed)
        self._level_v = 0.0

    def ready(self) -> int:
        """Samples that exist by now and were not taken yet."""
        return max(0, self._until() - self._next)

    def _until(self) -> int:
        now_s = self._bench.clock.now_s()
        edges = self._bench.edges(0, now_s)
        if len(edges) and not edges.finished and now_s - edges.time_s[-1] < _PATIENCE_S:
            now_s = float(edges.time_s[-1])
        return int((now_s - self._from_s) * self._rate_hz)

    def take(self, n: int) -> tuple[Floats, Floats]:
        """Give ``(n,)`` volts of the detector and ``(n,)`` of the sync."""
        settings, time_s = self._settings, self._from_s + (self._next + np.arange(n)) / self._rate_hz
        self._next += n
        # An edge and a sample at the same instant are apart by the last bits of their clocks: the edge comes first.
        edge_s = self._bench.edges(0, self._bench.clock.now_s()).time_s - 1e-9
        which = np.searchsorted(edge_s, time_s, side="right") - 1
        light = np.append(self._bench.counts(0, max(0, len(edge_s) - 1)).astype(np.float64), 0.0)
        level = np.where((which >= 0) & (which < len(light)), light[np.clip(which, 0, len(light) - 1)], 0.0)
        clean = self._followed(level * settings.volts_per_light)
        sign = 1.0 if settings.polarity == "positive" else -1.0
        noisy = sign * clean + settings.offset_v + self._noise.normal(0.0, 1.0, n) * settings.noise_v
        since_s = time_s - edge_s[np.clip(which, 0, None)] if len(edge_s) else np.full(n, np.inf)
        sync = np.where((which >= 0) & (since_s < settings.sync_width_s), settings.sync_high_v, 0.0)
        return np.clip(noisy, -settings.range_v, settings.range_v), sync

    def _followed(self, level: Floats) -> Floats:
        """A preamplifier of one pole, exact for levels that are constant between samples."""
        tau_s = self._settings.settle_s
        keep = float(np.exp(-1 / (self._rate_hz * tau_s))) if tau_s else 0.0
        if not len(level):
            return level
        followed, _ = lfilter([1 - keep], [1, -keep], level, zi=[keep * self._level_v])
        self._level_v = float(followed[-1])
        return np.asarray(followed, np.float64)
