"""What the README shows can be copied: its files load, its links lead somewhere; commands and Python run in other tests here."""

import re
from pathlib import Path

from instrument.config import load_bench
from instrument.plan import Plan

ROOT = Path(__file__).parents[2]
TEXT = (ROOT / "README.md").read_text(encoding="utf-8")


def _blocks(language: str) -> list[str]:
    return re.findall(rf"^```{language}\n(.*?)^```", TEXT, re.DOTALL | re.MULTILINE)


def test_both_files_load(tmp_path: Path) -> None:
    bench, plan = _blocks("toml")
    (tmp_path / "bench.toml").write_text(bench)
    (tmp_path / "plan.toml").write_text(plan)
    assert {name: device.installed.name for name, device in load_bench(tmp_path / "bench.toml").devices.items()} == {
        "modulator": "dlp7000",
        "counter": "ni",
        "stage": "ka400z",
    }
    assert Plan.from_toml(tmp_path / "plan.toml").patterns == 9996


def test_every_link_to_a_file_leads_to_one() -> None:
    links = re.findall(r"\]\(([^)#:]+)", TEXT)
    assert len(links) > 10
    assert [link for link in links if not (ROOT / link).exists()] == []
