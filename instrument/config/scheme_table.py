"""The ``[scheme]`` table of plan.toml: the name of the plan's scheme, and that scheme's own settings.

Schemes are found by entry point (group ``kinopix.schemes``), as drivers are, so that a third party can bring one.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Generic, TypeVar, cast

from pydantic import field_validator

from instrument.config.check import validate_table
from instrument.config.discovery import Fault, PluginBroken, PluginMissing, find_plugin, register_plugin_type
from instrument.config.document import Document
from instrument.config.errors import Problem
from protocols import Frozen

DEFAULT_SCHEME = "fourier-hadamard"
"""Name of the scheme of a plan that names none."""


class SchemeSettings(Frozen):
    """The part that the settings of all schemes have in common. A scheme's own model adds its keys."""

    patterns_per_frame: ClassVar[int]
    """Number of patterns in one frame."""

    name: str
    """Name under which the scheme is installed. A scheme's own model has it as default, and takes no other."""

    @field_validator("name")
    @classmethod
    def _is_own(cls, name: str) -> str:
        own = cls.model_fields["name"].default
        if name != own:
            raise ValueError(f"is {name}: these are the settings of {own}")
        return name

    def check(self, image_size: int, superpixel: int) -> None:
        """Raise ValueError where these settings do not fit the field. Its text begins with the key that is wrong.

        These common settings fit every field.

        Args:
            image_size: pixels a side of the field.
            superpixel: mirrors a side of one pixel.
        """
        del image_size, superpixel


SettingsT = TypeVar("SettingsT", bound=SchemeSettings)


@dataclass(frozen=True)
class SchemePlugin(Generic[SettingsT]):
    """A scheme: what it is, what it can be told, and how it is made for a plan."""

    summary: str
    """One line for ``kinopix drivers``."""

    settings: type[SettingsT]
    """Model of the ``[scheme]`` table."""

    make: Callable[[Any, SettingsT], object]
    """Makes the ``Scheme`` that serves a ``Plan`` with these settings."""


def _fault(name: str, plugin: SchemePlugin[Any]) -> Fault | None:
    """Say why the settings of a scheme cannot be a plan's: they are no ``SchemeSettings``, or another scheme's."""
    settings: type = plugin.settings
    if not issubclass(settings, SchemeSettings):
        return (
            f"settings {settings.__name__} that are no SchemeSettings",
            "a subclass of instrument.config.SchemeSettings",
        )
    if not isinstance(getattr(settings, "patterns_per_frame", None), int):
        return f"settings {settings.__name__} without patterns_per_frame", "the patterns in a frame, as class variable"
    own = settings.model_fields["name"].default
    if own != name:
        return (
            f"settings {settings.__name__} whose name is {own!r}",
            f"the name of its entry point, {name!r}, as default",
        )
    return None


register_plugin_type("scheme", SchemePlugin, _fault)


def scheme_plugin(name: str) -> SchemePlugin[Any]:
    """Find a scheme by name.

    Raises:
        PluginMissing: no installed distribution offers the scheme, or several do.
        PluginBroken: the plug-in cannot be imported, or is no ``SchemePlugin``.
    """
    return cast("SchemePlugin[Any]", find_plugin("scheme", name).load())


def settings_of(table: object) -> SchemeSettings:
    """Give the settings of a scheme from its name, from its table, or from these settings themselves.

    Raises:
        ValueError: the argument is neither of them, or the scheme does not take the table (``ValidationError``).
        PluginMissing: there is no such scheme.
    """
    if isinstance(table, SchemeSettings):
        return table
    if isinstance(table, str):
        table = {"name": table}
    if not isinstance(table, dict):
        raise ValueError("scheme: give its name, or a table with its name and settings")  # noqa: TRY004 - pydantic turns a ValueError, and no TypeError, into its own error
    values = {"name": DEFAULT_SCHEME, **cast("dict[str, Any]", table)}
    settings: SchemeSettings = scheme_plugin(str(values["name"])).settings.model_validate(values)
    return settings


def scheme_problems(document: Document) -> list[Problem]:
    """List every mistake of the scheme's entry in plan.toml, each with its line and a suggestion."""
    table = document.values.get("scheme", DEFAULT_SCHEME)
    as_table = isinstance(table, dict)
    values = cast("dict[str, Any]", table) if as_table else {"name": table}
    name = values.get("name", DEFAULT_SCHEME)
    where = ("scheme", "name") if as_table and "name" in values else ("scheme",)
    line = document.line_of(where)
    if not isinstance(name, str):
        key = ".".join(where)
        return [Problem(document.path, line, key, f"{name!r}", "the name of a scheme", f'"{DEFAULT_SCHEME}"')]
    try:
        model = scheme_plugin(name).settings
    except (PluginMissing, PluginBroken) as error:
        return [Problem(document.path, line, ".".join(where), error.saw, error.expected, error.remedy)]
    if not as_table:
        return []
    _, problems = validate_table(model, {"name": name, **values}, document, ("scheme",))
    return problems
