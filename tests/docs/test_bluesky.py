"""The program of ``docs/how-to/bluesky.md`` runs, from its first line to its last."""

import re
from pathlib import Path

import pytest

from tests.support.benches import bench_toml

pytest.importorskip("bluesky", reason="bluesky is not installed: no RunEngine")

PAGE = Path(__file__).parents[2] / "docs" / "how-to" / "bluesky.md"


def test_the_program_of_the_page_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    bench_toml(tmp_path, 'noise = { kind = "poisson", peak_counts = 200, seed = 1 }')
    blocks = re.findall(r"```python\n(.*?)```", PAGE.read_text(encoding="utf-8"), re.DOTALL)
    assert len(blocks) == 5
    exec("\n".join(blocks), {"__name__": "page"})  # noqa: S102 - what a reader would type
    speeds = [float(line.split()[0]) for line in capsys.readouterr().out.splitlines() if line.endswith(" px/s")]
    assert len(speeds) == 5
    assert speeds == sorted(speeds)
    assert sorted(path.name for path in (tmp_path / "recordings").iterdir()) == [
        f"kinopix-000{k}.h5" for k in range(1, 6)
    ]
