"""The tool that changes the source: what it changes, what it leaves alone, and that nothing is left behind."""

import subprocess
from pathlib import Path

import pytest

from benchmarks.mutations import Tree, belonging_tests, choose, mutants_of

KEPT = '''"""Nothing of this can be changed: 1 + 1."""
from typing import Literal, TypeAlias
Way: TypeAlias = Literal[1, -1]
@marked(cache=True)
def kept(way: Literal[1, 2], name: str) -> Literal[3]:
    """Add 1 to 2."""
    return f"{way + 1} of {name}"
'''


def changes(line: str) -> set[str]:
    source = f"{line}\n".encode()
    return {mutant.apply(source).decode().strip() for mutant in mutants_of("a.py", source)}


@pytest.mark.parametrize(
    ("line", "changed"),
    [
        ("a = b + c", {"a = b - c"}),
        ("a = (b)  *  (c)", {"a = (b)  /  (c)"}),
        ("a = b // c % d ** e", {"a = b * c % d ** e", "a = b // c * d ** e", "a = b // c % d * e"}),
        ("a -= b", {"a += b"}),
        ("a = -b", {"a = b"}),
        ("a = b < c <= d", {"a = b <= c <= d", "a = b < c < d"}),
        ("a = b > c >= d", {"a = b >= c >= d", "a = b > c > d"}),
        ("a = b == c != d", {"a = b != c != d", "a = b == c == d"}),
        ("a = b and not c", {"a = b or not c", "a = b and c"}),
        ("a = b or c or d", {"a = b and c or d", "a = b or c and d"}),
        ("a = 0.5", {"a = 1.0"}),
        ("a = 0.0", {"a = 1.0"}),
        ("a = b[2]", {"a = b[3]"}),
        ("a = True", {"a = False"}),
        ("a = min(b, np.maximum(c, d))", {"a = max(b, np.maximum(c, d))", "a = min(b, np.minimum(c, d))"}),
        ("a = b.argmin() if c.any() else d", {"a = b.argmax() if c.any() else d", "a = b.argmin() if c.all() else d"}),
        ("a = 'µ' + b", {"a = 'µ' - b"}),
    ],
)
def test_each_kind_of_change_is_found_and_changes_nothing_else(line: str, changed: set[str]) -> None:
    assert changes(line) == changed


def test_messages_annotations_decorators_and_texts_are_left_alone() -> None:
    assert mutants_of("kept.py", KEPT.encode()) == ()


def test_a_change_says_file_line_and_what_becomes_of_the_line() -> None:
    source = b"a = 1\nif a < b:\n    c()\n"
    described = [mutant.describe(source) for mutant in mutants_of("x/y.py", source)]
    assert described == ["x/y.py:1: 1 -> 2: a = 2", "x/y.py:2: < -> <=: if a <= b:"]


def test_a_change_of_a_source_that_is_another_one_is_refused() -> None:
    mutant = mutants_of("a.py", b"a = b + c\n")[0]
    with pytest.raises(ValueError, match=r"a\.py:1: expected '\+', saw b'-'"):
        mutant.apply(b"a = b - c\n")


@pytest.fixture
def project(tmp_path: Path) -> Path:
    """A work tree with one module, one test that sees its sign and none that sees its bound."""
    root = tmp_path / "project"
    for name, text in {
        "pkg/near.py": "def near(a: int, b: int) -> bool:\n    return a - b < 2\n",
        "pkg/deep/far.py": "FAR = 1\n",
        "protocols/conformance/suite.py": "ONE = 1\n",
        "tests/pkg/test_near.py": (
            "from pkg.near import near\n\ndef test_near():\n    assert near(3, 3)\n    assert not near(3, 0)\n"
        ),
        "tests/pkg/test_other.py": "def test_nothing():\n    pass\n",
        "pytest.ini": "[pytest]\naddopts = -p no:kinopix-conformance\n",
        ".gitignore": "*.h5\n",
        "run.h5": "ignored",
    }.items():
        (root / name).parent.mkdir(parents=True, exist_ok=True)
        (root / name).write_text(text, encoding="utf-8")
    subprocess.run(["git", "init", "--quiet"], cwd=root, check=True)
    return root


def test_the_same_seed_chooses_the_same_changes_and_never_the_tests_among_the_source(project: Path) -> None:
    every = choose(project, ["pkg", "protocols"], 100, 1)
    assert sorted(mutant.describe((project / mutant.path).read_bytes()) for mutant in every) == [
        "pkg/deep/far.py:1: 1 -> 2: FAR = 2",
        "pkg/near.py:2: - -> +: return a + b < 2",
        "pkg/near.py:2: 2 -> 3: return a - b < 3",
        "pkg/near.py:2: < -> <=: return a - b <= 2",
    ]
    assert choose(project, ["pkg"], 2, 5) == choose(project, ["pkg"], 2, 5)
    with pytest.raises(ValueError, match="saw nothing to change"):
        choose(project, ["protocols"], 1, 1)


def test_tests_belong_to_a_file_by_its_name_then_its_folder_then_the_one_above(project: Path) -> None:
    assert belonging_tests(project, "pkg/near.py") == ("tests/pkg/test_near.py", "tests/pkg")
    assert belonging_tests(project, "pkg/deep/far.py") == ("tests/pkg",)
    assert belonging_tests(project, "other/far.py") == ("tests",)
    assert belonging_tests(project, "protocols/stage.py") == ("tests", "tests/conformance")


def test_a_change_that_a_test_sees_is_killed_and_the_work_tree_stays_as_it_is(project: Path, tmp_path: Path) -> None:
    before = {path: path.read_bytes() for path in sorted(project.rglob("*")) if path.is_file()}
    tree = Tree(tmp_path / "home", project)
    assert not (tree.root / "run.h5").exists()
    fates = {
        mutant.new: tree.try_out(mutant, ["tests/pkg"], 60.0)
        for mutant in mutants_of("pkg/near.py", (project / "pkg/near.py").read_bytes())
    }
    assert fates == {"+": "killed", "<=": "SURVIVED", "3": "SURVIVED"}
    assert (tree.root / "pkg/near.py").read_bytes() == (project / "pkg/near.py").read_bytes()
    assert {path: path.read_bytes() for path in sorted(project.rglob("*")) if path.is_file()} == before


@pytest.mark.thorough
def test_a_change_that_never_ends_is_killed_by_time(project: Path, tmp_path: Path) -> None:
    (project / "pkg/near.py").write_text("while 1 - 1:\n    pass\n\ndef near(a, b):\n    return a - b < 2\n")
    tree = Tree(tmp_path / "home", project)
    endless = mutants_of("pkg/near.py", b"while 1 - 1:\n    pass\n")[1]
    assert endless.new == "+"
    assert tree.try_out(endless, ["tests/pkg"], 3.0) == "killed by time"
    assert tree.passes(["tests/pkg"])
