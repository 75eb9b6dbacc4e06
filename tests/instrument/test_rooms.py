"""The rooms of the framework are entered through their faces."""

import ast
from pathlib import Path

import instrument

HOME = Path(str(instrument.__file__)).parent


def past_the_face(source: str, room: str) -> list[str]:
    """Modules of other rooms that a module of ``room`` imports past their faces, wherever in its text."""
    names: list[str] = []
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            names.append(node.module)
        elif isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
    return [name for name in names if name.count(".") > 1 and name.split(".")[:2] not in (["instrument", room], [])]


def test_no_module_reaches_past_the_face_of_another_room() -> None:
    reached: dict[str, list[str]] = {}
    for path in sorted(HOME.rglob("*.py")):
        inside = path.relative_to(HOME)
        names = past_the_face(path.read_text(encoding="utf-8"), inside.parts[0])
        reached[str(inside)] = [name for name in names if name.startswith("instrument.")]
    assert {name: names for name, names in reached.items() if names} == {}


def test_a_reach_past_a_face_is_seen_wherever_it_stands() -> None:
    source = "from instrument.numerics import smooth\ndef f():\n    from instrument.numerics.spline import Spline\n"
    assert past_the_face(source, "tracking") == ["instrument.numerics.spline"]
    assert past_the_face(source, "numerics") == []
    assert past_the_face("import instrument.storage.hdf5\n", "cli") == ["instrument.storage.hdf5"]
