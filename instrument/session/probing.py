"""Who is on the bench: each device opened alone, asked, and let go of."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Final

from instrument.config import load_bench
from instrument.roles import COUNTER, MODULATOR, STAGE, RoleName
from instrument.session.instrument import Instrument
from protocols import DeviceIdentity, KinopixError


@dataclass(frozen=True)
class Probed:
    """What a device told."""

    role: RoleName
    """Its place on the bench."""

    driver: str
    """Driver that bench.toml names."""

    figures: Mapping[str, str] = field(default_factory=dict[str, str])
    """Identity, state and limits, in words; none where it did not open."""

    limits: Mapping[str, Any] = field(default_factory=dict[str, Any])
    """Its limits, in the units that their names say."""

    identity: DeviceIdentity | None = None
    """Who it is; None where it did not open."""

    doubts: tuple[str, ...] = ()
    """What a person should know before trusting it."""

    error: KinopixError | None = None
    """Why it did not open, or answer."""

    def as_dict(self) -> dict[str, Any]:
        """The same for JSON."""
        return {
            "driver": self.driver,
            "ok": self.error is None,
            "identity": None if self.identity is None else self.identity.model_dump(mode="json"),
            "limits": dict(self.limits),
            "state": {name: text for name, text in self.figures.items() if name in _STATE},
            "doubts": list(self.doubts),
            "error": None if self.error is None else str(self.error),
        }


_STATE: Final = ("playing", "position", "origin")


def probe_bench(path: str | Path) -> tuple[Probed, ...]:
    """Open the devices of a bench one at a time and ask each who it is. Nothing moves, nothing is shown, nothing is counted.

    A device that does not open is among the answers, with its error. Roles that bench.toml leaves out are left out.

    Raises:
        ConfigError: mistakes in the file.
    """
    found: list[Probed] = []
    config = load_bench(path, (), calibrated=False)
    for role, device in config.devices.items():
        driver = device.installed.name
        try:
            with Instrument.from_config(config, only=(role,)) as bench:
                found.append(_asked(bench, role, driver))
        except KinopixError as error:
            found.append(Probed(role, driver, error=error))
    return tuple(found)


def _asked(bench: Instrument, role: RoleName, driver: str) -> Probed:
    device: Any = bench.devices.by_role[role]
    identity: DeviceIdentity = device.identity
    told, doubts = _TOLD[role](bench) if role in _TOLD else ({}, [])
    if identity.simulated:
        doubts.append("no hardware stands behind it")
    figures = {
        "device": " ".join(part for part in (identity.vendor, identity.model) if part),
        "serial": identity.serial or "not told",
        "firmware": identity.firmware or "not told",
        "driver": identity.driver or driver,
        **told,
    }
    return Probed(role, driver, figures, device.limits.model_dump(mode="json"), identity, tuple(doubts))


def _modulator(bench: Instrument) -> tuple[dict[str, str], list[str]]:
    limits = bench.modulator.limits
    figures = {
        "mirrors": f"{limits.columns} x {limits.rows}",
        "picture time": f"{limits.shortest_picture_time_us} us ({1e6 / limits.shortest_picture_time_us:.0f} pictures/s) to "
        f"{limits.longest_picture_time_us * 1e-6:g} s",
        "memory": f"{limits.unique_patterns} patterns, {limits.play_order_entries} pictures in the play order",
        "playing": "yes" if bench.modulator.running else "no",
    }
    return figures, ["it plays: another program may hold it"] if bench.modulator.running else []


def _counter(bench: Instrument) -> tuple[dict[str, str], list[str]]:
    limits = bench.counter.limits
    figures = {
        "sync edges": f"up to {limits.max_sync_rate_hz:,.0f} a second",
        "linear": f"up to {limits.max_count_rate_hz:,.0f} counts/s",
        "dead time": f"{limits.dead_time_s * 1e9:.3g} ns",
        "dark counts": f"{limits.dark_rate_hz:.4g} /s",
        "edge times": "none"
        if limits.edge_time_resolution_s is None
        else f"in steps of {limits.edge_time_resolution_s * 1e9:.3g} ns",
    }
    doubts: list[str] = []
    if not limits.dark_rate_hz:
        doubts.append("no dark rate is stated: measure it with kinopix calibrate detector")
    if limits.edge_time_resolution_s is None:
        doubts.append("without edge times a lost sync edge is seen in the counts alone")
    return figures, doubts


def _stage(bench: Instrument) -> tuple[dict[str, str], list[str]]:
    stage, limits = bench.stage, bench.stage.limits
    position = stage.position()
    low, high = limits.travel_mm
    figures = {
        "position": f"{position.reported_mm:.4f} mm",
        "origin": "known" if stage.homed else "not known",
        "travel": f"{low:g} to {high:g} mm",
        "at most": f"{limits.max_velocity_mm_s:g} mm/s, {limits.max_acceleration_mm_s2:g} mm/s^2",
    }
    doubts = [] if stage.homed else ["it does not know its origin: kinopix move home"]
    if position.predicted:
        doubts.append("its position is predicted: the controller is mute")
    return figures, doubts


_TOLD: Final = {MODULATOR.name: _modulator, COUNTER.name: _counter, STAGE.name: _stage}
