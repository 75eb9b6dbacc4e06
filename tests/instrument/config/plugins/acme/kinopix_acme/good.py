"""Plug-ins that work. Their devices are plain objects: nothing here is opened as a bench."""

from pathlib import Path

from pydantic import PositiveFloat

from protocols import (
    Availability,
    BenchContext,
    DriverPlugin,
    Frozen,
    MonotonicClock,
    Scene,
    ScenePlugin,
    TransportPlugin,
)


class ProjectorSettings(Frozen):
    """Keys of ``[modulator]``."""

    port: str
    """Where it is plugged in."""

    sync_width_us: PositiveFloat = 5.0
    """Length of the sync pulse."""


class CounterSettings(Frozen):
    """Keys of ``[counter]``."""

    threshold_v: float = 0.5
    """Comparator level."""

    dead_time_s: PositiveFloat = 20e-9
    """Of the detector."""


class AxisSettings(Frozen):
    """Keys of ``[stage]``."""

    travel_mm: tuple[float, float] = (0.0, 400.0)
    """Both ends."""


class WireSettings(Frozen):
    """Keys of ``[<device>.emulator]``."""

    answer_delay_s: PositiveFloat = 0.01
    """How slow it is."""


class SceneSettings(Frozen):
    """Keys of ``[scene]``."""

    object: str
    """What moves."""


def open_device(settings: Frozen, context: BenchContext) -> tuple[Frozen, BenchContext]:
    """Give back what was given."""
    return settings, context


def open_scene(settings: SceneSettings, folder: Path) -> Scene:
    """Refuse: no test opens this scene."""
    raise NotImplementedError(f"{settings} in {folder} with {MonotonicClock()}")


def library_missing() -> Availability:
    """Say what is missing."""
    return Availability(ready=False, missing="libacme: install it from the maker's CD")


def look_around() -> Availability:
    """Fail as a careless plug-in does."""
    raise OSError("bus error")


projector = DriverPlugin("Acme projector", ProjectorSettings, open_device, availability=library_missing)
counter = DriverPlugin("Acme counter", CounterSettings, open_device)
axis = DriverPlugin("Acme axis", AxisSettings, open_device, availability=look_around)
wire = TransportPlugin("Acme on a wire", WireSettings, open_device)
scene = ScenePlugin("Acme desk", SceneSettings, open_scene)
