"""Simulated benches for calibrations: a steady lamp, whose counts go with the picture time."""

from typing import Any

from instrument.config import bench_of_tables
from instrument.session import Instrument

WHOLE = {"object": "square", "object_height_px": 32, "start_px": [16, 16]}
"""Light on the whole field of 32 px."""


def bench_of(scene: dict[str, Any] | None = None, *, mcps: float = 5.0, **noise: Any) -> Instrument:
    """Open modulator and counter, with a lamp that gives ``mcps`` million photons a second in a white picture."""
    photons = {"kind": "poisson", "peak_counts": mcps * 50, "peak_in_s": 5e-5, "seed": 1, **noise}
    devices = {role: {"driver": "simulated"} for role in ("modulator", "counter", "stage")}
    tables = {**devices, "scene": {**WHOLE, "noise": photons, "fresh_noise": True, **(scene or {})}}
    return Instrument.from_config(bench_of_tables(tables, "test"), only=("modulator", "counter"))
