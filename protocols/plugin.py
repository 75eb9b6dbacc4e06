"""How a driver, a transport or a scene is found and opened: a value behind an entry point.

Groups: ``kinopix.modulators``, ``kinopix.counters``, ``kinopix.stages`` (each a ``DriverPlugin``), ``kinopix.transports`` (a
``TransportPlugin``: what a real driver talks through instead of its hardware) and ``kinopix.scenes`` (a ``ScenePlugin``).
"""

from collections.abc import Callable
from dataclasses import dataclass, field
from pathlib import Path
from typing import Generic, TypeVar

from pydantic import BaseModel

from protocols.clock import Clock, MonotonicClock
from protocols.commissioning import NO_QUESTIONS, BenchQuestion
from protocols.scene import Scene
from protocols.values import Frozen

SettingsT = TypeVar("SettingsT", bound=BaseModel)
DeviceT = TypeVar("DeviceT")


class Availability(Frozen):
    """Answer to the question whether a driver can be used on this machine now."""

    ready: bool
    """True where nothing is missing."""

    version: str = ""
    """Version of the vendor library; empty where there is none."""

    missing: str = ""
    """Sentence that says what is missing and how to get it; empty where ready."""


@dataclass(frozen=True)
class BenchContext:
    """Surroundings that a plug-in is given beside its settings."""

    clock: Clock = field(default_factory=MonotonicClock)
    """Clock for every wait and every time stamp."""

    scene: Scene | None = None
    """The simulated bench, where bench.toml has a ``[scene]``."""

    transport: object | None = None
    """Object to talk through instead of the hardware, where bench.toml names a ``transport``."""

    folder: Path = field(default_factory=Path)
    """Folder of bench.toml: relative paths in settings start here."""


def always_ready() -> Availability:
    """Answer for a plug-in that needs nothing but Python."""
    return Availability(ready=True)


def probe_nothing() -> tuple[str, ...]:
    """Answer for a plug-in that cannot look for devices."""
    return ()


@dataclass(frozen=True)
class DriverPlugin(Generic[SettingsT, DeviceT]):
    """A driver: what it is for, what it can be told, how it is opened."""

    summary: str
    """One line of text for ``kinopix drivers``."""

    settings: type[SettingsT]
    """Model of the driver's own keys in bench.toml."""

    open: Callable[[SettingsT, BenchContext], DeviceT]
    """Function that opens the device; the device is a context manager that closes it."""

    availability: Callable[[], Availability] = always_ready
    """Function that looks for the vendor library and so on, without touching a device."""

    probe: Callable[[], tuple[str, ...]] = probe_nothing
    """Function that looks for devices and tells one line for each; it asks nothing that could move or show anything."""

    questions: tuple[BenchQuestion[SettingsT], ...] = NO_QUESTIONS
    """What ``kinopix probe --commission`` asks of a new device, beside what it asks of every one."""


@dataclass(frozen=True)
class TransportPlugin(Generic[SettingsT]):
    """A transport: what a real driver talks through instead of its hardware, such as an emulator, a recorder or a bridge."""

    summary: str
    """One line of text for ``kinopix drivers``."""

    settings: type[SettingsT]
    """Model of the ``[<device>.emulator]`` table in bench.toml."""

    open: Callable[[SettingsT, BenchContext], object]
    """Function that gives the transport object that the driver expects (its documentation says which)."""


@dataclass(frozen=True)
class ScenePlugin(Generic[SettingsT]):
    """A simulated bench."""

    summary: str
    """One line of text for ``kinopix drivers``."""

    settings: type[SettingsT]
    """Model of the ``[scene]`` table in bench.toml."""

    open: Callable[[SettingsT, Path], Scene]
    """Function that builds the scene; paths in the settings are relative to the folder given."""
