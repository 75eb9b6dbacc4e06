"""The optical bench that simulated devices and wire emulators share: scene, motion, light, photon statistics, clock, faults."""

from sim_backends.bench.bench import OpticalBench, bench_of
from sim_backends.bench.clock import BenchClock, RealTimeClock, VirtualClock
from sim_backends.bench.projection import Edges, Projection
from sim_backends.bench.settings import SceneSettings

__all__ = [
    "BenchClock",
    "Edges",
    "OpticalBench",
    "Projection",
    "RealTimeClock",
    "SceneSettings",
    "VirtualClock",
    "bench_of",
]
