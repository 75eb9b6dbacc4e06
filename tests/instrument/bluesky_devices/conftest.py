"""RunEngines whose documents are all held against the schemas of the event model. Without bluesky these tests are skipped."""

from collections.abc import Generator
from importlib import import_module
from pathlib import Path
from typing import Any

import pytest

from instrument import Instrument
from tests.support.benches import bench_toml

Documents = list[tuple[str, dict[str, Any]]]


@pytest.fixture(scope="session")
def engine() -> Any:
    """A RunEngine for all tests: its event loop has a thread of its own, which lives as long as the program."""
    from bluesky import RunEngine

    return RunEngine({}, context_managers=[])


@pytest.fixture
def documents(engine: Any) -> Generator[Documents]:
    """What the engine emits, valid by its schemas."""
    event_model: Any = import_module("event_model")  # typed in parts
    told: Documents = []

    def take(name: str, document: dict[str, Any]) -> None:
        event_model.schema_validators[event_model.DocumentNames[name]].validate(document)
        told.append((name, document))

    engine.ignore_callback_exceptions = False
    token = engine.subscribe(take)
    yield told
    engine.unsubscribe(token)


@pytest.fixture
def bench(tmp_path: Path) -> Generator[Instrument]:
    """A simulated bench in virtual time."""
    with Instrument.from_toml(bench_toml(tmp_path, 'noise = { kind = "poisson", peak_counts = 200, seed = 1 }')) as it:
        yield it


@pytest.fixture
def real_time_bench(tmp_path: Path) -> Generator[Instrument]:
    """One whose time passes as ours does, so that a run can be caught while it goes on."""
    scene = 'realtime = true\nnoise = { kind = "poisson", peak_counts = 200, seed = 1 }'
    with Instrument.from_toml(bench_toml(tmp_path, scene)) as it:
        yield it
