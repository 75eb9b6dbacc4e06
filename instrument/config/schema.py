"""What may stand in bench.toml and in plan.toml, as JSON schema: for editors, and for the pages of the reference.

It is made from the models of the framework and of every plug-in that is installed, so that it says what this machine takes.
"""

from collections.abc import Mapping, Sequence
from typing import Any, Final, Literal, TypeAlias, cast

from pydantic import BaseModel
from pydantic.json_schema import GenerateJsonSchema, models_json_schema

from instrument.config.bench import table_of, whole_file
from instrument.config.discovery import PluginBroken, installed_plugins
from instrument.roles import ROLES
from protocols.field_docs import field_docstrings, own_docstring

JsonSchema: TypeAlias = dict[str, Any]
"""A schema, or a part of one."""

_DIALECT: Final = "https://json-schema.org/draft/2020-12/schema"


class _Documented(GenerateJsonSchema):
    """A schema whose properties carry the docstrings of the fields."""

    def model_schema(self, schema: Any) -> JsonSchema:
        """Give the schema of one model."""
        made = super().model_schema(schema)
        if "description" in made:
            made["description"] = own_docstring(schema["cls"])
        meanings = field_docstrings(schema["cls"])
        for name, of_field in made.get("properties", {}).items():
            of_field.pop("title", None)
            if name in meanings:
                of_field["description"] = meanings[name]
        return made


def plugin_models(kind: str) -> dict[str, type[BaseModel]]:
    """Give the settings of every plug-in of a kind that can be loaded, by name."""
    models: dict[str, type[BaseModel]] = {}
    for installed in installed_plugins(kind):
        try:
            models[installed.name] = installed.load().settings
        except PluginBroken:
            continue
    return models


def bench_schema() -> JsonSchema:
    """Give the schema of bench.toml: a table for each role with the keys of each installed driver, the scene, what is known.

    Returns:
        JSON schema, draft 2020-12.
    """
    devices = {role.name: plugin_models(role.name) for role in ROLES}
    transports, scenes = plugin_models("transport"), plugin_models("scene")
    own, file = {role.name: table_of(role) for role in ROLES}, whole_file()
    groups = (*devices.values(), transports, scenes)
    of_model, definitions = _schemas([file, *own.values(), *(model for group in groups for model in group.values())])
    definitions["Transport"] = {"enum": sorted(transports)}
    definitions["Emulator"] = {"anyOf": [of_model[model] for model in transports.values()]}
    whole = _inlined(of_model[file], definitions)
    properties: JsonSchema = whole["properties"]
    for name, models in devices.items():
        table = _inlined(of_model[own[name]], definitions)
        for key in ("transport", "emulator"):
            table["properties"][key] |= {"anyOf": [{"$ref": f"#/$defs/{key.capitalize()}"}, {"type": "null"}]}
        choices = [_joined(table, of_model[model], definitions, driver) for driver, model in models.items()]
        properties[name] = {"description": f"The {name}, by its driver.", "anyOf": choices}
    kind: JsonSchema = {"properties": {"kind": {"default": "optical-bench"}}, "required": []}
    choices = [_joined(kind, of_model[model], definitions, name, "kind") for name, model in scenes.items()]
    properties["scene"] = {"description": "What stands before simulated devices.", "anyOf": choices}
    return _finished("bench.toml of Kinopix", whole, definitions)


def plan_schema(plan: type[BaseModel]) -> JsonSchema:
    """Give the schema of plan.toml, with the keys of each installed scheme.

    Args:
        plan: the model of the plan.

    Returns:
        JSON schema, draft 2020-12.
    """
    schemes = plugin_models("scheme")
    of_model, definitions = _schemas([plan, *schemes.values()])
    whole = _inlined(of_model[plan], definitions)
    tables = [
        _joined({"properties": {}, "required": []}, of_model[m], definitions, name, "name")
        for name, m in schemes.items()
    ]
    whole["properties"]["scheme"] |= {"anyOf": [{"enum": sorted(schemes)}, *tables]}
    whole["properties"]["scheme"].pop("$ref", None)
    return _finished("plan.toml of Kinopix", whole, definitions)


def _schemas(models: list[type[BaseModel]]) -> tuple[Mapping[type[BaseModel], JsonSchema], JsonSchema]:
    """Make the schemas of several models at once, so that they share their definitions."""
    mode: Literal["validation"] = "validation"
    unique = list(dict.fromkeys(models))
    by_key, rest = models_json_schema([(model, mode) for model in unique], schema_generator=_Documented)
    return {model: by_key[model, mode] for model in unique}, rest.get("$defs", {})


def _inlined(schema: JsonSchema, definitions: JsonSchema) -> JsonSchema:
    """Give a copy that can be changed, a reference followed."""
    named = definitions[schema["$ref"].rsplit("/", 1)[1]] if "$ref" in schema else schema
    return named | {"properties": {key: dict(value) for key, value in named.get("properties", {}).items()}}


def _joined(
    table: JsonSchema, settings: JsonSchema, definitions: JsonSchema, name: str, key: str = "driver"
) -> JsonSchema:
    """Join a table's own keys with those of one plug-in, which is chosen by ``key``."""
    of_plugin = _inlined(settings, definitions)
    chosen: JsonSchema = dict(table["properties"].get(key, {})) | {"const": name}
    chosen.pop("type", None)
    required = [*table.get("required", []), *of_plugin.get("required", [])]
    return {
        "title": name,
        "type": "object",
        "description": of_plugin.get("description", ""),
        "properties": {**table["properties"], **of_plugin["properties"], key: chosen},
        "required": sorted(set(required)),
        "additionalProperties": False,
    }


def _finished(title: str, whole: JsonSchema, definitions: JsonSchema) -> JsonSchema:
    """Put the head on, and leave out the definitions that nothing refers to."""
    schema = {"$schema": _DIALECT, "title": title, **{key: value for key, value in whole.items() if key != "title"}}
    used: JsonSchema = {}
    waiting: list[Any] = [schema]
    while waiting:
        part = waiting.pop()
        if isinstance(part, dict):
            values = cast("JsonSchema", part)
            name = str(values.get("$ref", "")).rsplit("/", 1)[-1]
            if name in definitions and name not in used:
                used[name] = definitions[name]
                waiting.append(used[name])
            waiting.extend(values.values())
        elif isinstance(part, list):
            waiting.extend(cast("Sequence[Any]", part))
    return {**schema, "$defs": dict(sorted(used.items()))} if used else schema
