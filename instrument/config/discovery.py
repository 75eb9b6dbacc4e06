"""Plug-ins by name: drivers, transports, scenes and schemes that any installed distribution offers as entry points.

Nothing is skipped and nothing is replaced: a plug-in that is missing or broken is an error that says so.
"""

import os
import sys
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import lru_cache
from importlib.metadata import EntryPoint, entry_points
from typing import Any, Protocol, TypeAlias, cast

from pydantic import BaseModel

from instrument.config.suggest import suggest_value
from instrument.roles import ROLES
from protocols import Availability, DriverPlugin, InputError, ScenePlugin, TransportPlugin

PluginKind: TypeAlias = str
"""What a plug-in is: the name of a device's role, or transport, scene, scheme; its entry point group is ``kinopix.`` and the
plural."""


class Plugin(Protocol):
    """The part that plug-ins of all kinds have in common."""

    @property
    def summary(self) -> str:
        """One line that ``kinopix drivers`` shows."""
        ...

    @property
    def settings(self) -> type[BaseModel]:
        """Model of the plug-in's own keys."""
        ...


RESERVED_KEYS = ("driver", "transport", "emulator", "on_abort", "px_per_mm")
"""Keys of a device table of bench.toml that the framework uses, so that no driver's settings may have them."""

_TYPES: dict[PluginKind, type] = {
    **{role.name: DriverPlugin for role in ROLES},
    "transport": TransportPlugin,
    "scene": ScenePlugin,
}


Fault: TypeAlias = tuple[str, str]
"""What was seen of a plug-in that cannot serve, and what was expected."""

_CHECKS: dict[PluginKind, Callable[[str, Any], Fault | None]] = {}


def register_plugin_type(kind: PluginKind, wanted: type, check: Callable[[str, Any], Fault | None]) -> None:
    """State of which type the plug-ins of a kind are; for kinds whose type stands on a higher floor than this module.

    Args:
        kind: which kind.
        wanted: the type.
        check: given a plug-in's name and a plug-in of that type, says why it cannot serve; None where it can.
    """
    _TYPES[kind] = wanted
    _CHECKS[kind] = check


class PluginMissing(InputError):
    """No installed distribution offers a plug-in of that name, or more than one does."""


class PluginBroken(InputError):
    """The plug-in is installed, but importing it fails or gives something else than a plug-in."""


@dataclass(frozen=True)
class InstalledPlugin:
    """A plug-in as its distribution announces it. It is not imported before ``load``."""

    kind: PluginKind
    """Kind of the plug-in."""

    name: str
    """Name that a configuration file refers to it by."""

    distribution: str
    """Distribution that offers it."""

    version: str
    """Version of that distribution."""

    entry_point: EntryPoint
    """Entry point that imports it."""

    @property
    def origin(self) -> str:
        """Kind, name, distribution and version as text for messages."""
        return f"{self.kind} plug-in {self.name!r} of {self.distribution} {self.version}"

    def load(self) -> Plugin:
        """Import the plug-in.

        Raises:
            PluginBroken: the import fails, or gives no plug-in of this kind.
        """
        try:
            found: object = self.entry_point.load()
        except Exception as error:  # third-party code may raise anything while it is imported
            saw = f"{type(error).__name__}: {error}"
            raise self._broken(saw, f"{self.entry_point.value} to import without an error") from error
        wanted: type = _TYPES[self.kind]
        if not isinstance(found, wanted):
            saw = f"{self.entry_point.value} of type {type(found).__name__}"
            raise self._broken(saw, f"a {wanted.__module__.split('.')[0]}.{wanted.__name__}")
        plugin = cast("Plugin", found)
        self._check_settings(plugin.settings)
        fault = _CHECKS[self.kind](self.name, plugin) if self.kind in _CHECKS else None
        if fault is not None:
            raise self._broken(*fault)
        return plugin

    def load_driver(self) -> DriverPlugin[Any, Any]:
        """Import the plug-in of a modulator, a counter or a stage, as ``load`` does."""
        return cast("DriverPlugin[Any, Any]", self.load())

    def load_transport(self) -> TransportPlugin[Any]:
        """Import the plug-in of a transport, as ``load`` does."""
        return cast("TransportPlugin[Any]", self.load())

    def load_scene(self) -> ScenePlugin[Any]:
        """Import the plug-in of a scene, as ``load`` does."""
        return cast("ScenePlugin[Any]", self.load())

    def _check_settings(self, settings: type[BaseModel]) -> None:
        if settings.model_config.get("extra", "ignore") == "ignore":
            raise self._broken(
                f"settings {settings.__name__} that ignore keys they do not know",
                "settings that forbid them, such as a protocols.Frozen",
            )
        if self.kind in {"transport", "scene", "scheme"}:
            return
        for key in RESERVED_KEYS:
            if key in settings.model_fields:
                raise self._broken(f"settings {settings.__name__} with the key {key}", "another name for that key")

    def _broken(self, saw: str, expected: str) -> PluginBroken:
        remedy = f"repair or reinstall {self.distribution} {self.version}, or choose another plug-in"
        return PluginBroken(device=self.origin, saw=saw, expected=expected, remedy=remedy)


@dataclass(frozen=True)
class PluginLine:
    """One line of ``kinopix drivers``."""

    plugin: InstalledPlugin
    """The plug-in."""

    summary: str = ""
    """The plug-in's own summary; empty where it cannot be loaded."""

    availability: Availability = field(default_factory=lambda: Availability(ready=False))
    """Whether the plug-in can be used on this machine now."""

    error: str = ""
    """Why it cannot be loaded, or why its check of availability failed; empty where nothing went wrong."""


def installed_plugins(kind: PluginKind) -> tuple[InstalledPlugin, ...]:
    """List the plug-ins of one kind by name, without importing any."""
    return _listed(kind, tuple((place, _changed_ns(place)) for place in sys.path))


@lru_cache(maxsize=32)
def _listed(kind: PluginKind, _places: tuple[tuple[str, int], ...]) -> tuple[InstalledPlugin, ...]:
    """List the plug-ins of one kind, once for a state of the path: the record of every distribution is read for it."""
    return tuple(sorted(_announced(kind), key=lambda plugin: (plugin.name, plugin.distribution)))


def _changed_ns(place: str) -> int:
    """When a folder of the path got or lost an entry; 0 where there is no folder."""
    try:
        return os.stat(place or ".").st_mtime_ns  # noqa: PTH116 - an entry of the path need not be a path's text
    except OSError:
        return 0


def find_plugin(kind: PluginKind, name: str) -> InstalledPlugin:
    """Give the one plug-in of that name.

    Raises:
        PluginMissing: there is no such plug-in, or more than one; the error names what is installed.
    """
    installed = installed_plugins(kind)
    found = [plugin for plugin in installed if plugin.name == name]
    if len(found) == 1:
        return found[0]
    if found:
        owners = " and ".join(f"{plugin.distribution} {plugin.version}" for plugin in found)
        raise PluginMissing(
            saw=f"the {kind} plug-in {name!r} offered by {owners}",
            expected="one distribution for each name",
            remedy="uninstall all but one of them",
        )
    names = [plugin.name for plugin in installed]
    hint = suggest_value(name, names)
    raise PluginMissing(
        saw=f"{name!r}, a {kind} plug-in that no installed distribution offers" + (f" ({hint})" if hint else ""),
        expected=f"one of {', '.join(names)}" if names else f"an installed {kind} plug-in: there is none",
        remedy="correct the name, or install the distribution that offers it; `kinopix drivers` lists all plug-ins",
    )


def list_plugins() -> tuple[PluginLine, ...]:
    """Load every plug-in and ask whether it can be used now. One that cannot be loaded is listed with its error."""
    return tuple(_line(plugin) for kind in _TYPES for plugin in installed_plugins(kind))


def _announced(kind: PluginKind) -> Iterator[InstalledPlugin]:
    """Find the entry points of one kind."""
    for entry_point in entry_points(group=f"kinopix.{kind}s"):
        owner = entry_point.dist
        yield InstalledPlugin(
            kind=kind,
            name=entry_point.name,
            distribution=owner.name if owner else "an unknown distribution",
            version=owner.version if owner else "",
            entry_point=entry_point,
        )


def _line(installed: InstalledPlugin) -> PluginLine:
    """Load a plug-in, and describe it or what went wrong."""
    try:
        plugin = installed.load()
    except PluginBroken as error:
        return PluginLine(installed, error=error.saw)
    if not isinstance(plugin, DriverPlugin):
        return PluginLine(installed, plugin.summary, Availability(ready=True))
    try:
        return PluginLine(installed, plugin.summary, plugin.availability())
    except Exception as error:  # noqa: BLE001 - a listing names every plug-in, whatever one of them raises
        return PluginLine(installed, plugin.summary, error=f"{type(error).__name__}: {error}")
