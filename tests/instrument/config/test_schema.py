"""The schemas take what the program takes, and refuse what it refuses; a foreign validator says so."""

import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast

import pytest
from jsonschema import Draft202012Validator

from instrument.config import bench_schema, plan_schema
from instrument.plan import MotionPlan, Plan
from protocols.field_docs import field_docstrings

ROOT = Path(__file__).parents[3]


@dataclass(frozen=True)
class Schema:
    """A schema, with a foreign validator behind it."""

    parts: dict[str, Any]

    def takes(self, values: object) -> bool:
        validator: Any = Draft202012Validator(self.parts)
        return bool(validator.is_valid(values))


@pytest.fixture(scope="module")
def bench() -> Schema:
    return Schema(bench_schema())


@pytest.fixture(scope="module")
def plan() -> Schema:
    return Schema(plan_schema(Plan))


def tables(path: Path) -> dict[str, Any]:
    return tomllib.loads(path.read_text(encoding="utf-8"))


def test_both_are_schemas(bench: Schema, plan: Schema) -> None:
    Draft202012Validator.check_schema(bench.parts)
    Draft202012Validator.check_schema(plan.parts)


@pytest.mark.parametrize("path", sorted((ROOT / "examples" / "benches").glob("*.toml")), ids=lambda path: path.stem)
def test_every_example_is_taken(bench: Schema, plan: Schema, path: Path) -> None:
    values = tables(path)
    assert (bench if "modulator" in values else plan).takes(values)


def test_what_a_first_run_begins_with_is_taken(bench: Schema, plan: Schema) -> None:
    start = ROOT / "instrument" / "cli" / "start"
    assert bench.takes(tables(start / "bench.toml"))
    assert plan.takes(tables(start / "plan.toml"))


@pytest.mark.parametrize(
    ("table", "change"),
    [
        ("modulator", {"driver": "simulatd"}),
        ("modulator", {"colums": 1024}),
        ("counter", {"dead_time_s": "20 ns"}),
        ("stage", {"on_abort": "fall"}),
        ("stage", {"travel_mm": [0.0]}),
        ("scene", {"edge_loss": 0.3}),
        ("scene", {"noise": {"kind": "poisson", "peak_count": 10}}),
        ("light", {"leak": -0.1}),
    ],
)
def test_a_mistake_is_refused(bench: Schema, table: str, change: dict[str, object]) -> None:
    simulated: dict[str, object] = {"driver": "simulated"}
    values: dict[str, dict[str, object]] = {
        "modulator": simulated,
        "counter": simulated,
        "stage": simulated,
        "scene": {},
    }
    assert bench.takes(values)
    assert not bench.takes({**values, table: {**values.get(table, {}), **change}})


@pytest.mark.parametrize(
    "change",
    [
        {"scheme": "fourier"},
        {"scheme": {"name": "hadamard", "fourier_cycles": 2}},
        {"frames": 0},
        {"frame": 10},
        {"motion": {}},
        {"motion": {"velocity_mm_s": 1.0, "acquire": "later"}},
    ],
)
def test_a_mistake_in_a_plan_is_refused(plan: Schema, change: dict[str, object]) -> None:
    assert plan.takes({"frames": 10, "scheme": {"name": "hadamard"}})
    assert plan.takes({"frames": 10, "scheme": "hadamard", "motion": {"velocity_mm_s": 1.0}})
    assert not plan.takes({"frames": 10, **change})


def test_a_table_needs_what_its_driver_needs(bench: Schema) -> None:
    simulated = {"driver": "simulated"}
    needed = {
        "lead_mm": 4.0,
        "microsteps": 8,
        "travel_mm": [0.0, 400.0],
        "max_velocity_mm_s": 50.0,
        "max_acceleration_mm_s2": 200.0,
        "home_velocity_mm_s": 5.0,
    }
    values = {"modulator": simulated, "counter": simulated}
    assert bench.takes({**values, "stage": {"driver": "ka400z", **needed}})
    for key in needed:
        others = {name: value for name, value in needed.items() if name != key}
        assert not bench.takes({**values, "stage": {"driver": "ka400z", **others}}), key


def test_a_field_s_docstring_is_found_as_it_stands() -> None:
    assert field_docstrings(MotionPlan)["velocity_mm_s"] == "Cruise velocity; its sign is the direction."
    assert list(field_docstrings(MotionPlan)) == list(MotionPlan.model_fields)


def keys_without_a_word(part: Any, path: str) -> Iterator[str]:
    """Every key of a schema that no text explains, however deep."""
    if isinstance(part, dict):
        tables = cast("dict[str, Any]", part)
        properties: dict[str, Any] = tables.get("properties", {})
        yield from (
            f"{path}.{key}"
            for key, value in properties.items()
            if "const" not in value and not value.get("description")
        )
        for key, value in tables.items():
            yield from keys_without_a_word(value, f"{path}.{key}")
    elif isinstance(part, list):
        for value in cast("Sequence[Any]", part):
            yield from keys_without_a_word(value, path)


def test_every_key_is_explained(bench: Schema, plan: Schema) -> None:
    assert list(keys_without_a_word({"properties": {"a": {"type": "string"}}}, "")) == [".a"]
    assert list(keys_without_a_word(bench.parts, "bench")) == []
    assert list(keys_without_a_word(plan.parts, "plan")) == []
