"""What a file may ask for, and where in it a value stands: each bound on both sides."""

from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from instrument.config import ConfigError
from instrument.config.document import MOST_BYTES, Document, beyond_measure, read_document
from instrument.config.errors import MOST_TOLD, Problem, shortened
from instrument.config.positions import key_lines
from instrument.config.suggest import suggest_key, unit_of

TEXT = """name = "x"

[motion]
velocity = 3

[[part]]
length = 1
[[part]]
length = 2
"""


@pytest.fixture
def path(tmp_path: Path) -> Path:
    return tmp_path / "plan.toml"


def _refused(path: Path, text: str) -> list[str]:
    path.write_text(text)
    with pytest.raises(ConfigError) as caught:
        read_document(path)
    return [str(problem).removeprefix(f"{path.parent}/") for problem in caught.value.problems]


# Places


def test_a_value_without_a_line_stands_where_the_nearest_table_above_it_does(path: Path) -> None:
    path.write_text(TEXT)
    document = read_document(path)
    assert document.line_of(("motion", "velocity")) == 4
    assert document.line_of(("motion", "acceleration")) == 3
    assert document.line_of(("motion", "velocity", "inner", "most")) == 4
    assert document.line_of(("part", 1, "width")) == 8
    assert document.line_of(("part", 7)) == 6
    assert document.line_of(("nowhere", "at all")) is None
    assert document.line_of(()) is None


def test_a_value_is_found_by_its_path_and_what_is_not_there_is_nothing(path: Path) -> None:
    path.write_text(TEXT)
    document = read_document(path)
    assert document.at(()) == {"name": "x", "motion": {"velocity": 3}, "part": [{"length": 1}, {"length": 2}]}
    assert document.at(("part", 1, "length")) == 2
    for missing in (("motion", "speed"), ("part", 2), ("motion", "velocity", "deeper"), ("part", "length"), ("x",)):
        assert document.at(missing) is None


@given(blank=st.integers(0, 30), comments=st.integers(0, 30))
def test_lines_above_a_key_move_it_down_by_their_number(blank: int, comments: int) -> None:
    moved = key_lines("\n" * blank + "# a = 1\n" * comments + TEXT)
    assert moved == {path: line + blank + comments for path, line in key_lines(TEXT).items()}


def test_a_table_that_was_named_before_it_has_a_header_stands_where_it_was_named() -> None:
    assert key_lines("a.b = 1\n[c.d]\n[c]\ne = 2\n") == {
        ("a",): 1, ("a", "b"): 1, ("c",): 2, ("c", "d"): 2, ("c", "e"): 4,
    }  # fmt: skip


# Bounds


def test_a_file_may_be_as_large_as_the_limit_and_not_a_byte_larger(path: Path) -> None:
    most = "a = 1\n#" + "x" * (MOST_BYTES - 7)
    path.write_text(most)
    assert read_document(path).values == {"a": 1}
    path.write_text(most + "x")
    with pytest.raises(ConfigError):
        read_document(path)


def test_a_line_may_hold_a_thousand_dots(path: Path) -> None:
    """A comment of 1000 dots is read, and of 1001 not; dots of other lines do not add up."""
    path.write_text("# " + "." * 1000 + "\n# " + "." * 1000 + "\na = 1\n")
    assert read_document(path).values == {"a": 1}
    assert _refused(path, "a = 1\n# " + "." * 1001) == [
        "plan.toml:2: saw a line with 1001 dots; expected 1000 at most (break long lists into lines)"
    ]


@pytest.mark.parametrize("number", [0, 1, -1, 2**63 - 1, -(2**63)])
def test_whole_numbers_of_64_bits_are_read(path: Path, number: int) -> None:
    """TOML 1.0: from -2^63 to 2^63 - 1 without loss."""
    path.write_text(f"a = {number}\n")
    assert read_document(path).values == {"a": number}


@pytest.mark.parametrize(("number", "bits"), [(2**63, 64), (2**64, 65), (-(2**70), 71)])
def test_whole_numbers_of_more_bits_are_refused_with_their_key_and_line(path: Path, number: int, bits: int) -> None:
    assert _refused(path, f"[t]\nok = 1\nlist = [0, {number}]\n") == [
        f"plan.toml:3: t.list.1: saw a whole number of {bits} bits and its sign; expected one that fits into 64 bits"
    ]


def test_every_number_beyond_measure_is_told(path: Path) -> None:
    found = _refused(path, f"a = {2**64}\nb = 5\nc = {2**65}\n")
    assert [line.split(" saw ")[0] for line in found] == ["plan.toml:1: a:", "plan.toml:3: c:"]


@pytest.mark.parametrize(("depth", "problems"), [(64, 0), (65, 1)])
def test_tables_may_be_64_deep(depth: int, problems: int) -> None:
    """The innermost value has as many keys as tables around it, the root included."""
    tables: dict[str, object] = {"k": 1}
    for _ in range(depth - 1):
        tables = {"k": tables}
    found = beyond_measure(Document(Path("plan.toml"), tables, {}))
    assert len(found) == problems
    assert all(problem.expected == "at most 64 in each other" for problem in found)


def test_bytes_that_are_not_utf_8_are_told_with_their_line(path: Path) -> None:
    """0xB5 is the micro sign of Latin-1, on line 3."""
    path.write_bytes(b'a = 1\nb = 2\nunit = "\xb5m"\n')
    with pytest.raises(ConfigError, match=r"plan\.toml:3: saw byte 0xb5, which is not UTF-8; expected UTF-8"):
        read_document(path)


# Mistakes


def _problem(line: int | None, key: str = "k") -> Problem:
    return Problem(Path("f.toml"), line, key, "this", "that")


def test_a_mistake_says_where_it_is_as_far_as_that_is_known() -> None:
    assert str(_problem(7)) == "f.toml:7: k: saw this; expected that"
    assert str(_problem(None)) == "f.toml: k: saw this; expected that"
    assert str(_problem(None, "")) == "f.toml: saw this; expected that"


def test_mistakes_come_in_the_order_of_the_file_and_those_without_a_line_first() -> None:
    error = ConfigError(Path("f.toml"), [_problem(9), _problem(None), _problem(2)])
    assert [problem.line for problem in error.problems] == [None, 2, 9]
    assert str(error).splitlines()[0] == "3 mistakes in f.toml:"


@pytest.mark.parametrize(
    ("count", "last"), [(1, "f.toml:1: k"), (20, "f.toml:20: k"), (21, "and 1 more"), (50, "and 30 more")]
)
def test_twenty_mistakes_are_told_and_the_others_counted(count: int, last: str) -> None:
    error = ConfigError(Path("f.toml"), [_problem(line) for line in range(1, count + 1)])
    lines = str(error).splitlines()
    assert len(lines) == 1 + min(count, MOST_TOLD) + (count > MOST_TOLD)
    assert lines[-1].strip().startswith(last)
    assert lines[0].startswith("1 mistake in" if count == 1 else f"{count} mistakes in")


@given(text=st.text(max_size=120))
def test_a_text_is_shortened_to_eighty_characters_or_left_alone(text: str) -> None:
    short = shortened(text)
    assert short == text if len(text) <= 80 else (len(short) == 80 and short == text[:77] + "...")


# Suggestions


@pytest.mark.parametrize(
    ("name", "split"),
    [
        ("px_per_mm", ("px", "1/mm")),
        ("MM", ("mm", "")),
        ("mm_s", ("mm", "s")),
        ("per_s", ("per", "s")),
    ],
)
def test_a_unit_is_what_stands_last_in_a_name(name: str, split: tuple[str, str]) -> None:
    assert unit_of(name) == split


def test_of_two_similar_keys_the_one_with_the_same_stem_is_meant() -> None:
    known = ["velocity_px_s", "velocity_limit_mm_s", "velocity_mm_s"]
    assert suggest_key("velocity_limit", known) == "did you mean velocity_limit_mm_s, in mm/s?"
    assert suggest_key("colour", known) == ""
