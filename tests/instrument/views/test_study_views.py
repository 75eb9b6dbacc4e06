"""Tables, page, figures and numbers of a study."""

import csv
from pathlib import Path

import numpy as np
import pytest
from matplotlib.image import imread
from rich.console import Console

from instrument.studies import STUDIES, Outcome, Result
from instrument.views import claims_table, study_index, study_page, study_tables, write_csv, write_study_pictures
from tests.instrument.studies import tiny


def outcome(psnr_db: float) -> dict[str, Outcome]:
    return {"one": Outcome({"mse_px2": psnr_db / 10, "psnr_db": psnr_db}, np.eye(4))}


@pytest.fixture(scope="module")
def result() -> Result:
    outcomes = {("a, 1", 0): outcome(1.0), ("a, 1", 1): outcome(2.0), ("a, 2", 0): outcome(5.0)}
    return Result(tiny.STUDY, 2, outcomes, {"noise: a, 2, seed 1": "ValueError: no"})


def text_of(table: object) -> list[str]:
    console = Console(width=120, record=True, file=Path("/dev/null").open("w"))  # noqa: SIM115
    with console.capture() as captured:
        console.print(table)
    console.file.close()
    return captured.get().splitlines()


def test_a_table_has_the_papers_figure_beside_ours(result: Result) -> None:
    mse, psnr = (text_of(table) for table in study_tables(result))
    assert mse[0].strip() == "displacement MSE, px²"
    assert [cell.strip() for cell in mse[4].strip("│").split("│")] == ["a, 1", "0.150 ± 0.071"]
    assert [cell.strip() for cell in psnr[2].strip("┃").split("┃")] == ["", "paper", "one"]
    assert [cell.strip() for cell in psnr[4].strip("│").split("│")] == ["a, 1", "1.50", "1.50 ± 0.71"]
    assert [cell.strip() for cell in psnr[5].strip("│").split("│")] == ["a, 2", "-", "5.00"]
    claims = text_of(claims_table(result))
    assert [line.strip("│ ").split("│") for line in claims[2:4]] == [
        ["holds         ", " 1.5"],
        ["does not hold ", " never"],
    ]


def test_a_page_tells_the_command_the_figures_the_claims_and_the_reasons(result: Result) -> None:
    page = study_page(result, ["noise.png"])
    assert page.startswith("# Tiny\n")
    assert "`kinopix reproduce noise --seeds 2`" in page
    assert "over the seeds 0 to 1" in page
    assert "|  | paper | one |\n| --- | ---: | ---: |\n| a, 1 | 1.50 | 1.50 ± 0.71 |\n| a, 2 | - | 5.00 |" in page
    assert "![Tiny](noise.png)" in page
    assert "- holds: 1.5\n- does not hold: never" in page
    assert page.rstrip().endswith("Points that failed are left out: noise: a, 2, seed 1")
    assert "- [Tiny](noise.md)\n- [Other](other.md)" in study_index([("noise", "Tiny"), ("other", "Other")])


def test_the_numbers_are_written_with_every_digit(result: Result, tmp_path: Path) -> None:
    over_all, of_each = write_csv(result, tmp_path)
    with over_all.open(newline="") as file:
        rows = list(csv.DictReader(file))
    assert rows[1] == {
        "case": "a, 1",
        "x": "1.0",
        "processing": "one",
        "figure": "psnr_db",
        "paper": "1.5",
        "mean": "1.5",
        "standard_deviation": repr(0.5**0.5),
        "seeds": "2",
    }
    with of_each.open(newline="") as file:
        assert [row["value"] for row in csv.DictReader(file) if row["figure"] == "psnr_db"] == ["1.0", "2.0", "5.0"]


def test_figures_are_drawn_as_png_and_pdf(result: Result, tmp_path: Path) -> None:
    names = [path.name for path in write_study_pictures(result, tmp_path)]
    assert names == ["noise.png", "noise.pdf", "noise-images.png", "noise-images.pdf"]
    assert (tmp_path / "noise.pdf").read_bytes().startswith(b"%PDF")
    picture = imread(tmp_path / "noise.png")
    assert np.ptp(picture[..., :3], axis=2).max() > 0.3  # a coloured line is in it
    assert write_study_pictures(Result(tiny.STUDY, 1, {}), tmp_path) == []
    alone = write_study_pictures(result, tmp_path, pdf=False)
    assert [path.name for path in alone] == ["noise.png", "noise-images.png"]


def test_a_table_is_drawn_as_points_with_the_papers(tmp_path: Path) -> None:
    study = STUDIES["table1"]
    outcomes = {
        (case.label, 0): {
            processing: Outcome({"mse_px2": 1.0, "psnr_db": 20.0, "ssim_global": 0.9, "ssim_local": 0.8}, np.eye(4))
            for processing in study.processings
        }
        for case in study.cases
    }
    files = write_study_pictures(Result(study, 1, outcomes), tmp_path, pdf=False)
    assert [path.name for path in files] == ["table1.png", "table1-images.png"]
