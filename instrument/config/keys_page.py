"""The page of a configuration file's keys, as Markdown, from its JSON schema: every key, its default, its bounds, its meaning."""

from collections.abc import Iterator
from typing import Any, Final, cast

from instrument.config.schema import JsonSchema

_HEAD: Final = "| key | takes | default | meaning |\n|---|---|---|---|\n"

_KINDS: Final = {
    "string": "text",
    "integer": "whole number",
    "number": "number",
    "boolean": "`true`, `false`",
    "object": "table",
}

_BOUNDS: Final = (("exclusiveMinimum", ">"), ("minimum", ">="), ("exclusiveMaximum", "<"), ("maximum", "<="))


def keys_page(schema: JsonSchema, title: str, introduction: str) -> str:
    """Write the page.

    Args:
        schema: of the whole file, as ``bench_schema`` and ``plan_schema`` give it.
        title: heading of the page.
        introduction: what stands below it.
    """
    definitions: JsonSchema = schema.get("$defs", {})
    parts = [f"# {title}\n\n{introduction}\n"]
    plain: JsonSchema = {}
    sections: list[str] = []
    for name, value in schema["properties"].items():
        tables = list(_tables(value, definitions))
        if not tables:
            plain[name] = value
            continue
        meaning = f"\n{_escaped(value['description'])}\n" if "description" in value else ""
        sections.append(f"## `[{name}]`\n{meaning}")
        sections += [_section(name, table, alone=len(tables) == 1) for table in tables]
    if plain:
        parts.append("## At the top of the file\n\n" + _rows(plain, schema.get("required", [])))
    parts += sections
    sections_of = {
        _name_of(part) for value in schema["properties"].values() for part in _choices(value) if "$ref" in part
    }
    used = sorted(definitions.keys() - sections_of, key=lambda name: (_short(name), name))
    if used:
        parts.append("## Tables and words inside tables\n")
        parts += [f"### `{_short(name)}`\n\n{_body(definitions[name])}" for name in used]
    return "\n".join(parts)


def _tables(value: JsonSchema, definitions: JsonSchema) -> Iterator[JsonSchema]:
    """Give the tables that may stand under a name."""
    for part in _choices(value):
        table = definitions[_name_of(part)] if "$ref" in part else part
        if "properties" in table:
            yield table


def _section(name: str, table: JsonSchema, *, alone: bool) -> str:
    properties: JsonSchema = table["properties"]
    chosen = [key for key, value in properties.items() if "const" in value]
    if alone and not chosen:
        return _body(table)
    heading = f'### `[{name}]` with `{chosen[0]} = "{properties[chosen[0]]["const"]}"`\n\n'
    return heading + _body(
        {**table, "properties": {key: of_key for key, of_key in properties.items() if key not in chosen}}
    )


def _body(table: JsonSchema) -> str:
    if "properties" not in table:
        return f"{takes(table)}\n"
    meaning = _escaped(table.get("description", ""))
    return (f"{meaning}\n\n" if meaning else "") + _rows(table["properties"], table.get("required", []))


def _rows(properties: JsonSchema, required: list[str]) -> str:
    rows = [
        f"| `{key}` | {takes(value)} | {_default(key, value, required)} | {_escaped(value.get('description', ''))} |\n"
        for key, value in properties.items()
    ]
    return (_HEAD + "".join(rows)) if rows else "No keys of its own.\n"


def _default(key: str, value: JsonSchema, required: list[str]) -> str:
    if key in required:
        return "*needed*"
    if isinstance(value.get("default"), dict):
        return "that table's own"
    default = default_of(value)
    return f"`{default}`" if default else "none"


def default_of(value: JsonSchema) -> str:
    """Give the default of a key as TOML has it; empty where it has none, or a whole table."""
    default = value.get("default")
    return "" if default is None or isinstance(default, dict) else _toml(default)


def _toml(value: object) -> str:
    if isinstance(value, list):
        return "[" + ", ".join(_toml(part) for part in cast("list[object]", value)) + "]"
    if isinstance(value, bool):
        return str(value).lower()
    return f'"{value}"' if isinstance(value, str) else f"{value}"


def takes(value: JsonSchema) -> str:
    """Say in words what a key takes."""
    return " or ".join(dict.fromkeys(_one(part) for part in _choices(value) if part.get("type") != "null"))


def _choices(value: JsonSchema) -> list[JsonSchema]:
    """Give the alternatives of a key, or the one thing that it takes."""
    alternatives: list[JsonSchema] = value.get("anyOf") or value.get("oneOf") or [value]
    return alternatives


def _one(part: JsonSchema) -> str:
    if "$ref" in part:
        return f"`{_short(_name_of(part))}`"
    if "const" in part or "enum" in part:
        return ", ".join(f"`{_toml(choice)}`" for choice in part.get("enum", [part.get("const")]))
    kind = _KINDS.get(str(part.get("type")), "anything")
    bounds = [f"{sign} {part[key]:g}" for key, sign in _BOUNDS if key in part]
    if part.get("type") == "array":
        items: list[Any] = part.get("prefixItems") or [part.get("items", {})]
        many = len(part.get("prefixItems", [])) or part.get("minItems", 0)
        return f"list of {many or 'any number'}: " + ", ".join(dict.fromkeys(takes(item) for item in items))
    return " ".join([kind, ", ".join(bounds)]).strip()


def _name_of(reference: JsonSchema) -> str:
    return str(reference["$ref"]).rsplit("/", 1)[1]


def _short(name: str) -> str:
    """Give a definition's name without the module that tells it from another of the same name."""
    return name.rsplit("__", 1)[-1]


def _escaped(text: str) -> str:
    """Give a docstring as Markdown in the cell of a table."""
    return text.replace("``", "`").replace("|", "\\|").replace("\n", " ")
