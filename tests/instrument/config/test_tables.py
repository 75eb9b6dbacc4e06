"""One table against one model: each kind of mistake with its place, and what was probably meant."""

from pathlib import Path
from typing import Annotated, Any

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import BaseModel, Field, model_validator

from instrument.config import ConfigError, load_bench
from instrument.config.bench import bench_of_tables
from instrument.config.check import fields_at, validate_table
from instrument.config.document import Document, read_document
from protocols import Frozen

pytestmark = pytest.mark.usefixtures("acme")


KEYS = "lens, part, count, list, width_mm"


class Lens(Frozen):
    focal_mm: Annotated[float, Field(gt=0, le=500)]
    name: str = "lens"


class Mirror(Frozen):
    tilt_deg: float


class Setup(Frozen):
    lens: Lens
    part: Lens | Mirror | None = None
    count: int = 1
    list: tuple[int, ...] = ()
    wide: float = Field(default=1.0, alias="width_mm")

    @model_validator(mode="after")
    def _even(self) -> "Setup":
        if self.count % 2 == 0:
            raise ValueError("count is even: one lens must stand in the middle")
        return self


def _problems(tmp_path: Path, text: str, *reserved: str, model: type[BaseModel] = Setup) -> list[str]:
    """Each mistake in the table ``setup`` without the name of the file."""
    path = tmp_path / "f.toml"
    path.write_text(text)
    document = read_document(path)
    found, problems = validate_table(model, document.values["setup"], document, ("setup",), reserved)
    assert (found is None) is bool(problems)
    return [str(problem).removeprefix(f"{path}:") for problem in problems]


def test_a_table_that_fits_gives_its_model_and_no_mistake(tmp_path: Path) -> None:
    assert _problems(tmp_path, "[setup]\nlens = { focal_mm = 500 }\nwidth_mm = 2\nlist = [1, 2]\n") == []


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ("lens = { focal_mm = 0 }", "2: setup.lens.focal_mm: saw 0; expected greater than 0"),
        ("lens = { focal_mm = 500.5 }", "2: setup.lens.focal_mm: saw 500.5; expected less than or equal to 500"),
        ('lens = { focal_mm = "7" }', '2: setup.lens.focal_mm: saw "7"; expected a number'),
        ("lens = 5", "2: setup.lens: saw 5; expected a table"),
    ],
)
def test_a_value_that_does_not_fit_is_told_in_the_words_of_toml(tmp_path: Path, line: str, problem: str) -> None:
    assert _problems(tmp_path, f"[setup]\n{line}\n") == [problem]


@pytest.mark.parametrize(
    ("line", "problem"),
    [
        ("count = 3.0", "3: setup.count: saw 3.0; expected a whole number"),
        ("count = true", "3: setup.count: saw true; expected a whole number"),
        ("list = [1, 2, 'x']", '3: setup.list.2: saw "x"; expected a whole number'),
        ("list = 5", "3: setup.list: saw 5; expected a list"),
        ("count = 4", "3: setup.count: saw 4; expected another value (count is even: one lens must stand in the middle)"),
        ("width = 4", f"3: setup.width: saw an unknown key; expected one of {KEYS} (did you mean width_mm, in mm?)"),
    ],
)  # fmt: skip
def test_one_mistake_beside_a_good_lens_is_one_problem(tmp_path: Path, line: str, problem: str) -> None:
    assert _problems(tmp_path, f"[setup]\nlens.focal_mm = 5\n{line}\n") == [problem]


def test_mistakes_come_in_the_order_of_their_lines(tmp_path: Path) -> None:
    """The model has lens before count before list; the file has them the other way round."""
    found = _problems(tmp_path, "[setup]\nlist = [0.5]\ncount = 'x'\nlens.focal_mm = -1\n")
    assert [line.split(":")[0] for line in found] == ["2", "3", "4"]


def test_keys_of_another_model_are_suggested_in_its_own_table_only(tmp_path: Path) -> None:
    """The framework takes ``driver`` in [setup], and not in [setup.lens]."""
    outer, inner = _problems(tmp_path, "[setup]\ndrivr = 'x'\n[setup.lens]\nfocal_mm = 1\ndrivr = 'x'\n", "driver")
    assert outer.endswith(f"expected one of {KEYS}, driver (did you mean driver?)")
    assert inner == "5: setup.lens.drivr: saw an unknown key; expected one of focal_mm, name"


@pytest.mark.parametrize(("length", "shown"), [(58, 60), (59, 60)])
def test_a_value_is_shown_with_sixty_characters_at_most(tmp_path: Path, length: int, shown: int) -> None:
    """Quotes and 58 letters are shown whole; of 59 letters the last are left out."""
    (problem,) = _problems(tmp_path, f"[setup]\nlens.focal_mm = 1\ncount = '{'x' * length}'\n")
    saw = problem.split("saw ")[1].split("; expected")[0]
    assert len(saw) == shown
    assert saw == ('"' + "x" * 58 + '"' if length == 58 else '"' + "x" * 56 + "...")


def test_keys_of_a_table_are_those_of_all_models_that_it_may_have() -> None:
    assert fields_at(Setup, ()) == ["lens", "part", "count", "list", "width_mm"]
    assert fields_at(Setup, ("lens",)) == ["focal_mm", "name"]
    assert fields_at(Setup, ("part",)) == ["focal_mm", "name", "tilt_deg"]
    assert fields_at(Setup, ("part", 3)) == ["focal_mm", "name", "tilt_deg"]
    assert fields_at(Setup, ("count",)) == []
    assert fields_at(Setup, ("wide",)) == []


@given(
    focal=st.floats(0.001, 500), count=st.integers(-(2**31), 2**31).map(lambda n: 2 * n + 1), name=st.text(max_size=9)
)
def test_a_good_table_comes_back_as_it_was_given(focal: float, count: int, name: str) -> None:
    values: dict[str, Any] = {"lens": {"focal_mm": focal, "name": name}, "count": count, "width_mm": 2.0}
    found, problems = validate_table(Setup, values, Document(Path("f.toml"), values, {}))
    assert problems == []
    assert found is not None
    assert found.model_dump(by_alias=True, exclude_unset=True) == values


# The whole bench


def _tables(**stage: object) -> dict[str, dict[str, object]]:
    return {
        "modulator": {"driver": "acme-projector", "port": "COM3"},
        "counter": {"driver": "acme-counter"},
        "stage": {"driver": "acme-axis", **stage},
    }


def test_a_scale_in_the_stage_table_is_refused_and_the_title_stands_for_the_file() -> None:
    with pytest.raises(ConfigError, match=r"here: stage\.px_per_mm: saw ") as caught:
        bench_of_tables(_tables(px_per_mm=7.2), "here")
    assert [problem.key for problem in caught.value.problems] == ["stage.px_per_mm"]
    assert "kinopix calibrate displacement" in str(caught.value)


def test_a_bench_is_the_same_from_a_file_as_from_its_tables(tmp_path: Path) -> None:
    path = tmp_path / "bench.toml"
    path.write_text(
        '[stage]\ndriver = "acme-axis"\non_abort = "hold"\n[counter]\ndriver = "acme-counter"\n'
        '[modulator]\ndriver = "acme-projector"\nport = "COM3"\n'
    )
    assert load_bench(path).as_json() == bench_of_tables(_tables(on_abort="hold"), "here").as_json()
    assert load_bench(path).folder == tmp_path
