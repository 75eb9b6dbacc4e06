"""A bench with a fourth device: one entry in the table of roles is all that the framework needs to know of it."""

import subprocess
import sys
from pathlib import Path

PLUGIN = """
from protocols import DeviceIdentity, DriverPlugin, Frozen


class LampSettings(Frozen):
    level: float = 1.0


class Lamp:
    identity = DeviceIdentity(name="lamp", vendor="acme", model="L1")

    def __init__(self, settings):
        self.level = settings.level

    def off(self):
        self.level = 0.0
        print("lamp off")

    def __enter__(self):
        print("lamp on at", self.level)
        return self

    def __exit__(self, *exc):
        print("lamp closed")


plugin = DriverPlugin(summary="a lamp", settings=LampSettings, open=lambda settings, context: Lamp(settings))
"""

SCRIPT = """
import sys
from instrument import roles

roles.ROLES = (*roles.ROLES, roles.Role("lamp", "NXsource", lambda lamp: lamp.off(), needed=False))

from instrument import Instrument, Plan, open_recording
from instrument.config import list_plugins
import h5py

print([line.plugin.name for line in list_plugins() if line.plugin.kind == "lamp"])
with Instrument.from_toml("bench.toml") as bench:
    bench.run(Plan(frames=3, image_size=8), "run.h5")
with h5py.File("run.h5") as file:
    print(file["entry/instrument/lamp"].attrs["NX_class"], file["entry/instrument/lamp/model"].asstr()[()])
    print('"level": 0.5' in file["entry/bench"].asstr()[()])
"""


def test_a_lamp_is_configured_opened_recorded_made_safe_and_closed(tmp_path: Path) -> None:
    (tmp_path / "lamp_plugin.py").write_text(PLUGIN)
    installed = tmp_path / "lamp-1.0.dist-info"
    installed.mkdir()
    (installed / "METADATA").write_text("Metadata-Version: 2.1\nName: lamp\nVersion: 1.0\n")
    (installed / "entry_points.txt").write_text("[kinopix.lamps]\nacme-lamp = lamp_plugin:plugin\n")
    tables = "".join(f'[{name}]\ndriver = "simulated"\n' for name in ("modulator", "counter", "stage"))
    (tmp_path / "bench.toml").write_text(f'{tables}[lamp]\ndriver = "acme-lamp"\nlevel = 0.5\n[scene]\n')
    (tmp_path / "script.py").write_text(SCRIPT)

    ran = subprocess.run([sys.executable, "script.py"], cwd=tmp_path, capture_output=True, text=True, check=False)

    assert ran.stderr == ""
    assert ran.stdout.splitlines() == [
        "['acme-lamp']",
        "lamp on at 0.5",
        "lamp off",
        "lamp closed",
        "NXsource L1",
        "True",
    ]
