"""Benchmarks use what any script can use, and none of the tests; nor do tests stand on benchmarks."""

import ast
from pathlib import Path

ROOT = Path(__file__).parents[2]


def imported_by(folder: str) -> dict[str, set[str]]:
    """File to the top-level packages that it imports, wherever in its text."""
    found: dict[str, set[str]] = {}
    for path in sorted((ROOT / folder).rglob("*.py")):
        names: set[str] = set()
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            if isinstance(node, ast.ImportFrom):
                names.add((node.module or "").split(".")[0])
            elif isinstance(node, ast.Import):
                names |= {alias.name.split(".")[0] for alias in node.names}
        found[str(path.relative_to(ROOT))] = names
    return found


def test_no_benchmark_imports_a_test() -> None:
    benchmarks = imported_by("benchmarks")
    assert "benchmarks/schemes.py" in benchmarks
    assert [name for name, packages in benchmarks.items() if "tests" in packages] == []


def test_only_tests_of_a_tool_import_it() -> None:
    """Figures are printed by benchmarks and asserted by tests: neither borrows from the other."""
    assert [
        name
        for name, packages in imported_by("tests").items()
        if "benchmarks" in packages and not name.startswith("tests/benchmarks/")
    ] == []


def test_every_benchmark_has_a_line_in_the_page() -> None:
    page = (ROOT / "benchmarks" / "README.md").read_text(encoding="utf-8")
    commands = [
        path.stem
        for path in (ROOT / "benchmarks").glob("*.py")
        if '__name__ == "__main__"' in path.read_text(encoding="utf-8")
    ]
    assert len(commands) >= 8
    assert [name for name in commands if f"python -m benchmarks.{name}" not in page] == []
