"""The reference of the simulated bench: its keys, defaults and figures are those that there are."""

import json
import re
import tomllib
from pathlib import Path
from typing import Any

import pytest
from pydantic import BaseModel
from pydantic_core import PydanticUndefined

from sim_backends.bench import SceneSettings
from sim_backends.bench.noise_settings import PhotonNoise

DOCS = Path(__file__).parents[2] / "docs"
PAGE = (DOCS / "reference" / "scene.md").read_text()
_ROW = re.compile(r"^\| `(\w+)` \| (.*?) \|$", re.MULTILINE)
ROWS = {name: [cell.strip() for cell in cells.split("|")] for name, cells in _ROW.findall(PAGE)}
"""Key to the cells after it."""

REAL = SceneSettings(realism="realistic")
IDEAL = SceneSettings()


def _written(value: Any) -> str:
    """A value as the page has it."""
    return "none" if value is None else f"`{json.dumps(value)}`"


def _held(model: type[BaseModel], ideal: Any, real: Any) -> set[str]:
    """Hold every key of a model that the page lists; give those."""
    for name in model.model_fields:
        if name in {"noise", "kind"}:
            continue
        default = model.model_fields[name].default
        assert default is not PydanticUndefined, name
        cells = ROWS[name]
        assert cells[0] == _written([] if default == () else default), name
        figure = getattr(real, name)
        if figure != getattr(ideal, name) and name != "realism":
            assert cells[1] == _written(figure), name
        elif len(cells) > 2:
            assert cells[1] in {"", _written(figure)}, name
    return set(model.model_fields) - {"noise", "kind"}


def test_every_key_is_on_the_page_with_its_default_and_its_realistic_figure() -> None:
    keys = _held(SceneSettings, IDEAL, REAL)
    photons = _held(PhotonNoise, PhotonNoise(kind="poisson"), REAL.noise)
    assert ROWS.keys() == keys | photons


def test_the_bench_on_the_page_can_be_opened() -> None:
    (block,) = re.findall(r"```toml\n(.*?)```", PAGE, re.DOTALL)
    scene = SceneSettings.model_validate(tomllib.loads(block)["scene"])
    assert (scene.realism, scene.blur_px, scene.edge_loss) == ("realistic", 0.0, REAL.edge_loss)
    assert isinstance(scene.noise, PhotonNoise)
    assert (scene.noise.peak_counts, scene.noise.dead_time_s) == (100.0, 20e-9)


def test_the_example_of_the_how_to_prints_what_it_says(capsys: pytest.CaptureFixture[str]) -> None:
    page = (DOCS / "how-to" / "realistic-bench.md").read_text()
    (block,) = re.findall(r"```python\n(.*?)```", page, re.DOTALL)
    exec(compile(block, "realistic-bench.md", "exec"), {})  # noqa: S102 - our own page
    first, second = re.findall(r"It prints `(.*?)` and `(.*?)`", page)[0]
    assert capsys.readouterr().out.splitlines() == [first, second]
