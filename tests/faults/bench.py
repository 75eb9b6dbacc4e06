"""A bench.toml for a row, and what is seen of a run on it."""

from dataclasses import dataclass
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np

from instrument.recording import Recording
from instrument.session import Instrument
from instrument.storage import open_recording
from protocols import Floats, KinopixError
from tests.faults.row import Row

_SCENE = """[scene]
noise = { kind = "poisson", peak_counts = 60, dark_rate_hz = 600, dead_time_s = 2e-8, seed = 5 }
"""

_STAGE = """driver = "ka400z"
transport = "{0}-emulator"
dialect = "{0}"
lead_mm = 4.0
microsteps = 8
travel_mm = [0.0, 400.0]
max_velocity_mm_s = 50.0
max_acceleration_mm_s2 = 200.0
home_velocity_mm_s = 5.0
"""

_DRIVERS = {
    "simulated": 'driver = "simulated"\n',
    "alp": 'driver = "dlp7000"\ntransport = "alp-emulator"\n',
    "dlpc900": 'driver = "dlpc900"\ntransport = "dlpc900-emulator"\n',
    "ni": 'driver = "ni"\ntransport = "ni-emulator"\n',
    "ni-analog": 'driver = "ni-analog"\ntransport = "ni-analog-emulator"\n',
    "usb-ctr": 'driver = "usb-ctr"\ntransport = "usb-ctr-emulator"\n',
    "serial-counter": """driver = "serial-counter"
transport = "serial-counter-emulator"
max_sync_rate_hz = 20000
""",
    "mc600": _STAGE.format("mc600"),
    "sc300": _STAGE.format("sc300"),
    "grbl": """driver = "grbl"
transport = "grbl-emulator"
travel_mm = [0.0, 400.0]
max_velocity_mm_s = 50.0
max_acceleration_mm_s2 = 200.0
unlock = true
""",
    "zaber": """driver = "zaber"
transport = "zaber-emulator"
microsteps_per_mm = 15625
travel_mm = [0.0, 400.0]
max_velocity_mm_s = 50.0
max_acceleration_mm_s2 = 200.0
""",
}

_EMULATORS = {
    "usb-ctr": {"fpga_configured": "true"},
    "mc600": {"travel_mm": "[0.0, 400.0]"},
    "sc300": {"travel_mm": "[0.0, 400.0]"},
}


def bench_toml(row: Row, folder: Path) -> Path:
    """Write the row's bench.toml, and a file that can pass for an FPGA image."""
    (folder / "image.rbf").write_bytes(b"\xff" * 64)
    text = ""
    tables = {"modulator": row.modulator, "counter": row.counter, "stage": row.stage}
    for table, driver in tables.items():
        keys, emulator = (row.keys, row.emulator) if table == row.faulty else ("", "")
        text += f"[{table}]\n{_DRIVERS[driver]}{keys}\n"
        usual = {k: v for k, v in _EMULATORS.get(driver, {}).items() if not f"\n{emulator}".count(f"\n{k} ")}
        lines = [f"{key} = {value}" for key, value in usual.items()] + ([emulator] if emulator else [])
        if lines:
            text += f"[{table}.emulator]\n" + "\n".join(lines) + "\n"
    path = folder / "bench.toml"
    path.write_text(text + _SCENE + row.scene + "\n")
    return path


@dataclass(frozen=True)
class Seen:
    """What a run left behind."""

    error: BaseException | None
    recording: Recording | None
    took_s: float
    """On the bench's clock."""

    dark: bool
    """Whether no picture was shown any more when ``run`` was left."""

    drift_mm: float
    """How far the object still went, from two seconds later on."""


def carry_out(bench: Instrument, row: Row, out: Path) -> Seen:
    """Run the row's plan and look at the bench afterwards, not at what the drivers say of it."""
    clock, scene = bench.devices.clock, scene_of(bench)
    begun_s, error = clock.now_s(), None
    try:
        bench.run(row.plan, out)
    except KinopixError as caught:
        error = caught
    took_s, dark = clock.now_s() - begun_s, bool(scene.shown_until_s <= clock.now_s())
    clock.sleep_s(2.0)
    at_mm: Floats = scene._carried[-1][1](clock.now_s() + np.arange(11.0))
    return Seen(error, open_recording(out) if out.exists() else None, took_s, dark, float(np.ptp(at_mm)))


def scene_of(bench: Instrument) -> Any:
    """The optical bench behind an instrument."""
    return bench.devices.scene


@cache
def undisturbed(frames: int, pattern_rate_hz: float) -> tuple[Floats, float]:
    """``(patterns,)`` counts of a run of the same seed without any fault, and the time that it took."""
    row = Row(fault="none", frames=frames, pattern_rate_hz=pattern_rate_hz)
    with TemporaryDirectory() as name, Instrument.from_toml(bench_toml(row, Path(name))) as bench:
        seen = carry_out(bench, row, Path(name) / "clean.h5")
    assert seen.recording is not None
    return seen.recording.values.ravel(), seen.took_s
