"""bench.toml: which plug-ins make up the bench, and their settings, checked against the plug-ins' own models."""

import json
from collections.abc import Collection, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Final, Generic, Literal, TypeAlias, TypeVar

from pydantic import BaseModel, ConfigDict, Field, ValidationError, create_model

from instrument.config.calibration_file import Calibration, read_calibration
from instrument.config.check import validate_table
from instrument.config.discovery import (
    InstalledPlugin,
    Plugin,
    PluginBroken,
    PluginKind,
    PluginMissing,
    find_plugin,
)
from instrument.config.document import Document, read_document
from instrument.config.errors import ConfigError, Problem
from instrument.config.light_table import NOTHING_KNOWN, LightTable
from instrument.config.positions import KeyPath
from instrument.roles import ROLES, Role, RoleName
from protocols import DriverPlugin, Frozen, ScenePlugin, TransportPlugin
from protocols.plain_file import path_of

OnAbort: TypeAlias = Literal["stop", "hold", "home"]
"""What the stage does after an abort: stop where it is, hold until the running move is done, or stop and look for home."""


class AnyTable(BaseModel):
    """A table whose keys are known only to a plug-in. Those that are not named here are in ``model_extra``."""

    model_config = ConfigDict(frozen=True, extra="allow")


class DeviceTable(AnyTable):
    """``[modulator]`` or ``[counter]``. All keys but these belong to the driver's settings."""

    driver: str
    """Name of the driver plug-in."""

    transport: str | None = None
    """Name of a transport plug-in to talk through instead of the hardware."""

    emulator: AnyTable | None = None
    """Settings of that transport."""


class StageTable(DeviceTable):
    """``[stage]``: as the others, and what to do after an abort."""

    on_abort: OnAbort = "stop"
    """What the stage does when a run is broken off."""


class SceneTable(AnyTable):
    """``[scene]``: all keys but ``kind`` belong to the scene's settings."""

    kind: str = "optical-bench"
    """Name of the scene plug-in."""


_TABLES: dict[RoleName, type[DeviceTable]] = {"stage": StageTable}
"""Tables that have keys of their own; all others are a ``DeviceTable``."""


def table_of(role: Role[Any]) -> type[DeviceTable]:
    """Give the model of the keys that the framework itself has in the table of a role."""
    return _TABLES.get(role.name, DeviceTable)


_WHOLE_BENCH: Final = tuple(role.name for role in ROLES if role.needed)
"""Roles that a bench cannot do without."""


def whole_file(needed: Collection[RoleName] = _WHOLE_BENCH) -> type[Frozen]:
    """bench.toml as it is written, before any plug-in is asked: a table for each role, and what else a bench has."""
    fields: dict[str, Any] = {
        role.name: (table_of(role), ...) if role.name in needed else (table_of(role) | None, None) for role in ROLES
    }
    return create_model(
        "BenchTables",
        __base__=Frozen,
        **fields,
        scene=(Annotated[SceneTable | None, Field(description=_SCENE)], None),
        light=(Annotated[LightTable, Field(description=_LIGHT)], NOTHING_KNOWN),
        calibration=(Annotated[_FileName | None, Field(description=_CALIBRATION)], None),
        magnification=(Annotated[str, Field(max_length=200, description=_MAGNIFICATION)], ""),
    )


_FileName: TypeAlias = Annotated[str, Field(min_length=1, max_length=1024)]

_SCENE: Final = "What stands before simulated devices."

_LIGHT: Final = "What is known of how the bench differs from an ideal one."

_CALIBRATION: Final = "Calibration file of this bench, as `kinopix calibrate` writes it, relative to bench.toml."

_MAGNIFICATION: Final = "Name of the optics between object and modulator: a calibration holds for one magnification."


PluginT = TypeVar("PluginT", bound=Plugin)


@dataclass(frozen=True)
class Resolved(Generic[PluginT]):
    """A plug-in with its checked settings: ready to be opened."""

    installed: InstalledPlugin
    """Its name, distribution and version."""

    plugin: PluginT
    """The plug-in itself."""

    settings: BaseModel
    """An instance of ``plugin.settings``."""

    transport: "Resolved[TransportPlugin[Any]] | None" = None
    """Devices only: what to talk through instead of the hardware."""

    def as_dict(self) -> dict[str, Any]:
        """What a recording keeps of it."""
        return {
            "name": self.installed.name,
            "distribution": self.installed.distribution,
            "version": self.installed.version,
            "settings": self.settings.model_dump(mode="json"),
            **({"transport": self.transport.as_dict()} if self.transport else {}),
        }


ResolvedDevice: TypeAlias = Resolved[DriverPlugin[Any, Any]]
"""A driver with its settings, and with its transport where bench.toml names one."""


@dataclass(frozen=True)
class BenchConfig:
    """bench.toml, checked: everything that is needed to open the bench. Nothing is open yet."""

    path: Path
    """The file it was read from."""

    devices: Mapping[RoleName, ResolvedDevice]
    """The driver in each role, in the order of the roles."""

    on_abort: OnAbort = "stop"
    """What the stage does when a run is broken off."""

    calibration: Calibration | None = None
    """What was measured of the bench, where bench.toml names a calibration file."""

    calibration_path: Path | None = None
    """That file."""

    magnification: str = ""
    """Name of the optics between object and modulator; a calibration holds for one of them."""

    scene: Resolved[ScenePlugin[Any]] | None = None
    """The simulated bench; None where all devices are real."""

    light: LightTable = NOTHING_KNOWN
    """What is known of how the bench differs from an ideal one."""

    @property
    def folder(self) -> Path:
        """Folder of bench.toml: relative paths in settings start here."""
        return self.path.parent

    def as_json(self) -> str:
        """The bench as a recording stores it: plug-ins with distribution, version and settings, defaults written out."""
        bench: dict[str, Any] = {name: device.as_dict() for name, device in self.devices.items()}
        if "stage" in bench:
            bench["stage"] |= {"on_abort": self.on_abort}
        bench["scene"] = self.scene.as_dict() if self.scene else None
        bench["light"] = self.light.model_dump(mode="json", exclude_none=True)
        bench["magnification"] = self.magnification
        bench["calibration"] = self.calibration.model_dump(mode="json") if self.calibration else None
        return json.dumps(bench, indent=2)


def load_bench(
    path: str | Path, needed: Collection[RoleName] = _WHOLE_BENCH, *, calibrated: bool = True
) -> BenchConfig:
    """Read bench.toml, the calibration file that it names, and find its plug-ins. Opens no device.

    Args:
        path: of bench.toml.
        needed: roles that must be there. One that is not may be left out of the file, as before a bench is whole; where its
            table is there, it is checked.
        calibrated: whether the calibration file is read; not for a bench that is to be calibrated, which may have none yet.

    Raises:
        ConfigError: every mistake in the file at once: in its tables, in plug-ins that are missing or broken, in their
            settings; or those in the calibration file.
    """
    return _checked(read_document(path_of(path)), needed, calibrated=calibrated)


def bench_of_tables(tables: Mapping[str, Any], title: str) -> BenchConfig:
    """Check what would stand in bench.toml, and find its plug-ins. Opens no device.

    Args:
        tables: table name to its keys, as ``tomllib`` would give them. Relative paths in them start at the working folder.
        title: stands in messages where the file's name would.

    Raises:
        ConfigError: every mistake at once, as ``load_bench``.
    """
    return _checked(Document(path=Path(title), values=dict(tables), lines={}))


def _checked(
    document: Document, needed: Collection[RoleName] = _WHOLE_BENCH, *, calibrated: bool = True
) -> BenchConfig:
    _, problems = validate_table(whole_file(needed), document.values, document)
    search = _Search(document, problems)
    found: dict[RoleName, ResolvedDevice | None] = {
        role.name: search.device(role) for role in ROLES if role.name in needed or role.name in document.values
    }
    scene = search.scene()
    stage = search.table("stage", StageTable) or StageTable(driver="")
    devices: dict[RoleName, ResolvedDevice] = {name: device for name, device in found.items() if device is not None}
    if problems or len(devices) < len(found):
        raise ConfigError(document.path, problems)
    light = search.table("light", LightTable) if "light" in document.values else None
    named: str | None = document.values.get("calibration")
    path = None if named is None else document.path.parent / path_of(named)
    calibration = read_calibration(path) if path is not None and calibrated else None
    return BenchConfig(
        path=document.path,
        devices=devices,
        on_abort=stage.on_abort,
        calibration=calibration,
        calibration_path=path,
        magnification=document.values.get("magnification", ""),
        scene=scene,
        light=_with_kind(light or NOTHING_KNOWN, calibration),
    )


def _with_kind(light: LightTable, calibration: Calibration | None) -> LightTable:
    """Give ``[light]`` with the kind of the dead time that was measured, where the file states none."""
    detector = None if calibration is None else calibration.detector
    if detector is None or detector.dead_time_kind is None or "dead_time_kind" in light.model_fields_set:
        return light
    return light.model_copy(update={"dead_time_kind": detector.dead_time_kind})


TableT = TypeVar("TableT", bound=BaseModel)


@dataclass(frozen=True)
class _Search:
    """Resolves what can be resolved, and adds what cannot to the problems."""

    document: Document
    problems: list[Problem]

    def device(self, role: Role[Any]) -> ResolvedDevice | None:
        kind, model = role.name, table_of(role)
        table = self.table(kind, model)
        if table is None:
            return None
        transport = self.transport(kind, table)
        installed = self.plugin(kind, table.driver, (kind, "driver"))
        if installed is None:
            return None
        driver = installed.load_driver()
        if kind == "stage" and "px_per_mm" in (table.model_extra or {}):
            table = self.without_scale(table)
        settings = self.settings(driver.settings, table, (kind,), tuple(model.model_fields))
        return None if settings is None else Resolved(installed, driver, settings, transport)

    def without_scale(self, table: DeviceTable) -> DeviceTable:
        """Refuse the scale that once stood here, and give the table without it."""
        self.report(
            ("stage", "px_per_mm"),
            "the image scale, which is no setting of the stage",
            'calibration = "calibration.toml" above all tables: a calibration says for which pixels a scale holds',
            "make it with `kinopix calibrate displacement`",
        )
        values = {**table.model_dump(), **(table.model_extra or {})}
        return type(table).model_validate({key: value for key, value in values.items() if key != "px_per_mm"})

    def transport(self, kind: str, table: DeviceTable) -> Resolved[TransportPlugin[Any]] | None:
        where: KeyPath = (kind, "emulator")
        if table.transport is None:
            if table.emulator is not None and self.document.at((kind, "transport")) is None:
                self.report(where, "settings of a transport, but no transport", f'transport = "..." in [{kind}]')
            return None
        installed = self.plugin("transport", table.transport, (kind, "transport"))
        if installed is None:
            return None
        transport = installed.load_transport()
        settings = self.settings(transport.settings, table.emulator or AnyTable(), where)
        return None if settings is None else Resolved(installed, transport, settings)

    def scene(self) -> Resolved[ScenePlugin[Any]] | None:
        table = self.table("scene", SceneTable)
        installed = None if table is None else self.plugin("scene", table.kind, ("scene", "kind"))
        if table is None or installed is None:
            return None
        scene = installed.load_scene()
        settings = self.settings(scene.settings, table, ("scene",), ("kind",))
        return None if settings is None else Resolved(installed, scene, settings)

    def table(self, name: str, model: type[TableT]) -> TableT | None:
        """The table, without its own keys that are wrong (they are reported already); None where it is of no use at all."""
        values: Any = self.document.values.get(name)
        try:
            return model.model_validate(values, strict=True)
        except ValidationError as error:
            wrong = {detail["loc"][0] for detail in error.errors() if detail["loc"]}
        try:
            return model.model_validate({key: value for key, value in values.items() if key not in wrong}, strict=True)
        except (ValidationError, AttributeError):  # no driver; no table
            return None

    def plugin(self, kind: PluginKind, name: str, where: KeyPath) -> InstalledPlugin | None:
        """The plug-in, if it is there and can be imported."""
        try:
            installed = find_plugin(kind, name)
            installed.load()
        except (PluginMissing, PluginBroken) as error:
            saw = f"{error.device}, which gives {error.saw}" if error.device else error.saw
            self.report(where, saw, error.expected, error.remedy)
            return None
        return installed

    def settings(
        self, model: type[BaseModel], table: AnyTable, where: KeyPath, reserved: tuple[str, ...] = ()
    ) -> BaseModel | None:
        settings, problems = validate_table(model, dict(table.model_extra or {}), self.document, where, reserved)
        self.problems.extend(problems)
        return settings

    def report(self, where: KeyPath, saw: str, expected: str, suggestion: str = "") -> None:
        key = ".".join(str(part) for part in where)
        self.problems.append(Problem(self.document.path, self.document.line_of(where), key, saw, expected, suggestion))
