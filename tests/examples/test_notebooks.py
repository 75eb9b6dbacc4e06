"""Every notebook runs from its first cell to its last, and shows what its text says."""

import json
import warnings
from pathlib import Path
from typing import Any

import matplotlib as mpl
import pytest

NOTEBOOKS = sorted((Path(__file__).parents[2] / "examples" / "notebooks").glob("*.ipynb"))


def run(path: Path) -> dict[str, Any]:
    """Run all cells of a notebook as one program; give its names."""
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    names: dict[str, Any] = {}
    for number, cell in enumerate(cells):
        assert not cell.get("outputs"), "notebooks are kept without what they printed"
        if cell["cell_type"] == "code":
            exec(compile("".join(cell["source"]), f"{path.name}, cell {number}", "exec"), names)  # noqa: S102 - our own
    return names


def test_an_hour_at_the_bench(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(mpl, "get_backend", lambda: "agg")
    mpl.use("agg")
    (path,) = NOTEBOOKS
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        names = run(path)
    assert names["plan"].patterns == 4800
    analysis = names["analysis"]
    assert analysis.figures.displacement_mse_px2 < 0.02
    assert analysis.figures.psnr_db > 25
    assert names["mse_px2"][0] > 3 * names["mse_px2"][-1], "more light, less error"
    leak = names["real"].light.leak
    assert leak.source == "fitted"
    assert leak.value == pytest.approx(0.0825, abs=4 * leak.sigma)
    names["plt"].close("all")
