"""The program of ``docs/how-to/tiled.md`` runs, where Tiled is installed."""

import re
from pathlib import Path
from typing import Any

import pytest

from tests.support.benches import bench_toml

pytest.importorskip("bluesky", reason="bluesky is not installed: no RunEngine")
pytest.importorskip("tiled.server", reason="Tiled is not installed: no catalogue")

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "tiled.md"


@pytest.mark.filterwarnings("default")
def test_the_program_of_the_page_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "recordings").mkdir()
    bench_toml(tmp_path, 'noise = { kind = "poisson", peak_counts = 200, seed = 1 }')
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert len(blocks) == 3
    names: dict[str, Any] = {"__name__": "page"}
    exec("\n".join(blocks), names)  # noqa: S102 - what a reader would type
    names["catalogue"].context.http_client.close()  # the end of the program would
    told = sorted(line for line in capsys.readouterr().out.splitlines() if " mm/s: " in line)
    assert told == ["10.0 mm/s: (60, 6) valid: 60", "20.0 mm/s: (60, 6) valid: 60"]
