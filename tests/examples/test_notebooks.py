"""Every notebook runs from its first cell to its last, and shows what its text says."""

import json
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import matplotlib as mpl
import matplotlib.pyplot as plt
import pytest

NOTEBOOKS = Path(__file__).parents[2] / "examples" / "notebooks"


def run(notebook: str) -> dict[str, Any]:
    """Run all cells of a notebook as one program; give its names."""
    path = NOTEBOOKS / f"{notebook}.ipynb"
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    names: dict[str, Any] = {}
    for number, cell in enumerate(cells):
        assert not cell.get("outputs"), "notebooks are kept without what they printed"
        if cell["cell_type"] == "code":
            exec(compile("".join(cell["source"]), f"{path.name}, cell {number}", "exec"), names)  # noqa: S102 - our own
    return names


@pytest.fixture(autouse=True)
def _pictures_are_not_shown(monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    monkeypatch.setattr(mpl, "get_backend", lambda: "agg")
    mpl.use("agg")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield
    plt.close("all")


def test_each_notebook_has_a_test() -> None:
    assert [path.stem for path in NOTEBOOKS.glob("*.ipynb") if f'"{path.stem}"' not in Path(__file__).read_text()] == []


def test_an_hour_at_the_bench() -> None:
    names = run("an_hour_at_the_bench")
    assert names["plan"].patterns == 4800
    analysis = names["analysis"]
    assert analysis.figures.displacement_mse_px2 < 0.02
    assert analysis.figures.psnr_db > 25
    assert names["mse_px2"][0] > 3 * names["mse_px2"][-1], "more light, less error"
    leak = names["real"].light.leak
    assert leak.source == "fitted"
    assert leak.value == pytest.approx(0.0825, abs=4 * leak.sigma)


@pytest.mark.thorough
def test_how_sure_is_it() -> None:
    """Of normal errors 68 and 95 % lie within one and two standard deviations; six runs scatter by some 15 %."""
    names = run("how_sure_is_it")
    assert 0.5 < names["inside"][1] < 0.95
    assert names["inside"][2] > 0.85
    assert names["holds"] >= 4
    assert names["outside"] <= 1, "a lamp that nobody told of may be uneven, and sigma covers that"
    assert min(names["wider"]) > 1.5
    assert names["found"].figures.misfit < 1.5, "and the misfit does not tell"


def test_which_scheme() -> None:
    """Three phase steps are surer than two, a centroid less sure than a phase, and smoothing helps all."""
    names = run("which_scheme")
    assert [len(recording) for recording in names["recordings"].values()] == [400, 600, 400, 800]
    frame_px, smooth_px = names["rms_px"], names["smooth_px"]
    assert frame_px["fourier-3step"] < frame_px["fourier-hadamard"] < frame_px["moment"] / 3
    assert all(smooth_px[scheme] < frame_px[scheme] / 5 for scheme in frame_px)
    assert [analysis.figures.psnr_db > 23 for analysis in names["analyses"].values()] == [True, True]
