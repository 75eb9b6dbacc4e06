"""Simulated benches for calibrations: a steady lamp, whose counts go with the picture time."""

from typing import Any

from instrument.config import bench_of_tables
from instrument.session import Instrument

WHOLE = {"object": "square", "object_height_px": 32, "start_px": [16, 16]}
"""Light on the whole field of 32 px."""


def bench_of(
    scene: dict[str, Any] | None = None, *, mcps: float = 5.0, stated_s: float | None = None, **noise: Any
) -> Instrument:
    """Open modulator and counter, with a lamp that gives ``mcps`` million photons a second in a white picture.

    ``stated_s`` is the dead time that the counter believes in; None, the true one.
    """
    photons = {"kind": "poisson", "peak_counts": mcps * 50, "peak_in_s": 5e-5, "seed": 1, **noise}
    devices: dict[str, dict[str, Any]] = {role: {"driver": "simulated"} for role in ("modulator", "counter", "stage")}
    if stated_s is not None:
        devices["counter"]["dead_time_s"] = stated_s
    tables = {**devices, "scene": {**WHOLE, "noise": photons, "fresh_noise": True, **(scene or {})}}
    return Instrument.from_config(bench_of_tables(tables, "test"), only=("modulator", "counter"))
