"""Every number that bench.toml and plan.toml can give to what is simulated has a least and a largest value."""

from collections.abc import Iterator, Sequence
from typing import Any, cast

import pytest

from instrument.config import PluginKind, RunTable, StopTable, installed_plugins
from instrument.plan import MotionPlan, Plan

SIMULATED: list[tuple[PluginKind, str]] = [
    ("scene", "optical-bench"),
    ("modulator", "simulated"),
    ("counter", "simulated"),
    ("stage", "simulated"),
    ("transport", "alp-emulator"),
    ("transport", "dlpc900-emulator"),
    ("transport", "grbl-emulator"),
    ("transport", "mc600-emulator"),
    ("transport", "ni-analog-emulator"),
    ("transport", "ni-emulator"),
    ("transport", "sc300-emulator"),
    ("transport", "serial-counter-emulator"),
    ("transport", "usb-ctr-emulator"),
    ("transport", "zaber-emulator"),
]


def unbounded(schema: object, path: str = "") -> Iterator[str]:
    """Numbers in a JSON schema that have no end on one side."""
    if isinstance(schema, list):
        for inner in cast("Sequence[Any]", schema):
            yield from unbounded(inner, path)
    if isinstance(schema, dict):
        table = cast("dict[str, Any]", schema)
        if table.get("type") in {"number", "integer"} and not table.keys() & {"const", "enum"}:
            ends = (table.keys() & {"minimum", "exclusiveMinimum"}, table.keys() & {"maximum", "exclusiveMaximum"})
            if not all(ends):
                yield path
        for key, inner in table.items():
            yield from unbounded(inner, f"{path}.{key}")


@pytest.mark.parametrize(("kind", "name"), SIMULATED)
def test_no_number_of_a_simulated_part_is_without_end(kind: PluginKind, name: str) -> None:
    plugin = next(each for each in installed_plugins(kind) if each.name == name)
    assert list(unbounded(plugin.load().settings.model_json_schema())) == []


@pytest.mark.parametrize("model", [Plan, MotionPlan, StopTable])
def test_no_number_of_a_plan_is_without_end(model: type[Plan | MotionPlan | StopTable]) -> None:
    tables = {"scheme", "motion", "run", "stop_if"}
    fields = {name: field for name, field in model.model_fields.items() if name not in tables}
    numbers = {name: str(field.metadata) + str(field.annotation) for name, field in fields.items()}
    for name, constraints in numbers.items():
        if "Literal" not in constraints and name != "pattern_rate_hz":  # its upper end is a rule with words of its own
            assert "Ge(" in constraints or "Gt(" in constraints, name
            assert "Le(" in constraints or "Lt(" in constraints, name


def test_no_text_of_a_plan_is_without_end() -> None:
    assert all("MaxLen(" in str(field.metadata) for field in RunTable.model_fields.values())


def test_all_that_is_simulated_is_looked_at() -> None:
    kinds: list[PluginKind] = ["scene", "transport"]
    announced = [(kind, plugin.name) for kind in kinds for plugin in installed_plugins(kind)]
    assert {*announced} <= {*SIMULATED}
