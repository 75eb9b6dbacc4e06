"""bench.toml and plan.toml to begin with: every key of the chosen plug-ins as a comment, with what it means and its default."""

import textwrap
from collections.abc import Iterator, Mapping
from typing import Final

from instrument.config.keys_page import default_of, takes
from instrument.config.schema import JsonSchema
from protocols import InputError

_WIDTH: Final = 100
_TABLES: Final = frozenset({"scheme", "motion", "run", "stop_if"})


def bench_template(schema: JsonSchema, drivers: Mapping[str, str]) -> str:
    """Write bench.toml for some drivers.

    Args:
        schema: ``bench_schema()``.
        drivers: name of the driver in each role.

    Raises:
        InputError: a driver that is not installed.
    """
    tables = schema["$defs"]
    whole = {"properties": {key: schema["properties"][key] for key in ("calibration", "magnification")}}
    parts = [
        '#:schema ./bench.schema.json\n# Written by kinopix init. A key behind "#" has the value that stands there.\n',
        "".join(_keys(whole, tables)),
    ]
    for role, driver in drivers.items():
        keys = _keys(_chosen(schema, role, driver, "driver"), tables, skip=("driver", "emulator"))
        parts.append(f'[{role}]\ndriver = "{driver}"\n{"".join(keys)}')
    if "simulated" in drivers.values():
        scene = schema["properties"]["scene"]["anyOf"][0]
        parts.append("[scene]\n" + "".join(_keys(scene, tables, skip=("kind",))))
    parts.append("[light]\n" + "".join(_keys(tables["LightTable"], tables)))
    return "\n".join(parts)


def plan_template(schema: JsonSchema, scheme: str) -> str:
    """Write plan.toml for a scheme: the paper's run of 1,666 frames, along the stage's axis.

    Args:
        schema: ``plan_schema(Plan)``.
        scheme: its name.

    Raises:
        InputError: a scheme that is not installed.
    """
    table = _chosen(schema, "scheme", scheme, "name")
    top = {
        **schema,
        "properties": {key: of for key, of in schema["properties"].items() if key not in _TABLES},
    }
    tables = schema["$defs"]
    return "\n".join(
        [
            '#:schema ./plan.schema.json\n# Written by kinopix init. A key behind "#" has the value that stands there.\n',
            "".join(_keys(top, tables, given={"frames": "1666"})),
            f'[scheme]\nname = "{scheme}"\n{"".join(_keys(table, tables, skip=("name",)))}',
            "[motion]                 # leave the whole table out for an object at rest\n"
            + "".join(_keys(tables["MotionPlan"], tables, given={"velocity_mm_s": "25.0"})),
            "[run]                    # what the run is about\n" + "".join(_keys(tables["RunTable"], tables)),
            "[stop_if]                # rules that end a run early; none where no time is given\n"
            + "".join(_keys(tables["StopTable"], tables)),
        ]
    )


def _chosen(schema: JsonSchema, name: str, plugin: str, key: str) -> JsonSchema:
    """Find the table of one plug-in."""
    tables: list[JsonSchema] = [table for table in schema["properties"][name]["anyOf"] if "properties" in table]
    for table in tables:
        if table["properties"][key]["const"] == plugin:
            return table
    names = ", ".join(str(table["properties"][key]["const"]) for table in tables)
    raise InputError(
        saw=f"the {name} {plugin!r}", expected=f"one of {names}", remedy="kinopix drivers lists what is installed"
    )


def _keys(
    table: JsonSchema, tables: JsonSchema, skip: tuple[str, ...] = (), given: Mapping[str, str] | None = None
) -> Iterator[str]:
    """Give the lines of each key: its meaning, and the key with its default as a comment, or with what is given."""
    required: list[str] = table.get("required", [])
    for key, value in table["properties"].items():
        if key in skip:
            continue
        meaning = str(value.get("description", "")).replace("``", "")
        yield "\n" + textwrap.indent(textwrap.fill(meaning, _WIDTH), "# ") + "\n"
        if given and key in given:
            yield f"{key} = {given[key]}\n"
        elif key == "transport":
            yield "# transport =              # a name that kinopix drivers lists\n"
        elif key in required:
            yield f"# {key} =              # needed: {_in_words(value, tables)}\n"
        else:
            default = default_of(value)
            yield f"# {key} = {default}\n" if default else f"# {key} =              # {_in_words(value, tables)}\n"


def _in_words(value: JsonSchema, tables: JsonSchema) -> str:
    """Say what a key takes; of a table, which keys it has."""
    text = takes(value)
    for name, table in tables.items():
        text = text.replace(f"`{name.rsplit('__', 1)[-1]}`", f"{{ {', '.join(table.get('properties', {}))} }}")
    return text.replace("`", "")
