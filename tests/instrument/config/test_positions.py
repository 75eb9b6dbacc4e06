"""Every key of a TOML text is found on its line."""

import json
import string
import tomllib
from typing import Any, cast

from hypothesis import given
from hypothesis import strategies as st

from instrument.config.positions import KeyPath, key_lines

TEXT = '''# a comment with [brackets] and key = value
title = "a # b ] = c"
"quoted key" = 1
'literal.key' = 2
"caf\\u00e9" = 3
dotted . inner."x y" = 4

[table]
long = """
not_a_key = 5
[neither]
"""
raw = \'\'\'
also = not
\'\'\'
list = [
    1,  # one ]
    "two, three",
    { in_line = 1, deep = { deeper = 2 } },
    [5, 6],
]
after = 1979-05-27T07:32:00Z
[table.sub] # header
x = true
[[many]]
name = "first"
[[many]]
name = "second"
[many.extra]
y = 1
[[many.parts]]
z = 1
[[many.parts]]
z = 2
'''

LINES: dict[KeyPath, int] = {
    ("title",): 2,
    ("quoted key",): 3,
    ("literal.key",): 4,
    ("café",): 5,
    ("dotted",): 6,
    ("dotted", "inner"): 6,
    ("dotted", "inner", "x y"): 6,
    ("table",): 8,
    ("table", "long"): 9,
    ("table", "raw"): 13,
    ("table", "list"): 16,
    ("table", "list", 0): 17,
    ("table", "list", 1): 18,
    ("table", "list", 2): 19,
    ("table", "list", 2, "in_line"): 19,
    ("table", "list", 2, "deep"): 19,
    ("table", "list", 2, "deep", "deeper"): 19,
    ("table", "list", 3): 20,
    ("table", "list", 3, 0): 20,
    ("table", "list", 3, 1): 20,
    ("table", "after"): 22,
    ("table", "sub"): 23,
    ("table", "sub", "x"): 24,
    ("many",): 25,
    ("many", 0): 25,
    ("many", 0, "name"): 26,
    ("many", 1): 27,
    ("many", 1, "name"): 28,
    ("many", 1, "extra"): 29,
    ("many", 1, "extra", "y"): 30,
    ("many", 1, "parts"): 31,
    ("many", 1, "parts", 0): 31,
    ("many", 1, "parts", 0, "z"): 32,
    ("many", 1, "parts", 1): 33,
    ("many", 1, "parts", 1, "z"): 34,
}


def test_each_key_is_found_on_its_line() -> None:
    assert key_lines(TEXT) == LINES


def test_windows_line_ends_count_as_one_line() -> None:
    assert key_lines(TEXT.replace("\n", "\r\n")) == LINES


def test_an_empty_text_has_no_keys() -> None:
    assert key_lines("") == {}
    assert key_lines("# only a comment") == {}


names = st.text(string.ascii_lowercase, min_size=1, max_size=3)
scalars = st.integers() | st.booleans() | st.sampled_from(['a "b" [c]', "x = 1\n[t]", "#", "", "'"])
trees: st.SearchStrategy[Any] = st.recursive(
    scalars, lambda inner: st.lists(inner, max_size=3) | st.dictionaries(names, inner, max_size=3), max_leaves=8
)


def inline(value: Any) -> str:
    """A value as TOML writes it on one line."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return json.dumps(value)
    if isinstance(value, int):
        return str(value)
    return "{" + pairs(value) + "}" if hasattr(value, "items") else "[" + ", ".join(map(inline, value)) + "]"


def pairs(table: dict[str, Any]) -> str:
    """What stands in an inline table."""
    return ", ".join(f"{key} = {inline(item)}" for key, item in table.items())


def children(value: Any) -> list[tuple[str | int, Any]]:
    """Keys and values of a table, indices and elements of a list."""
    if hasattr(value, "items"):
        return list(value.items())
    return list(enumerate(cast("list[Any]", value))) if hasattr(value, "append") else []


def paths(value: Any, path: KeyPath = ()) -> set[KeyPath]:
    """Every key path below a parsed value."""
    found: set[KeyPath] = set()
    for key, item in children(value):
        found |= {(*path, key)} | paths(item, (*path, key))
    return found


@given(
    st.dictionaries(names, trees, max_size=4),
    st.dictionaries(names, st.dictionaries(names, trees, max_size=3), max_size=3),
)
def test_the_scanner_sees_the_same_keys_as_the_parser(top: dict[str, Any], tables: dict[str, dict[str, Any]]) -> None:
    lines = [f"{key} = {inline(value)}" for key, value in top.items() if key not in tables]
    expected: dict[KeyPath, int] = {
        (key,): number for number, key in enumerate((key for key in top if key not in tables), 1)
    }
    for name, table in tables.items():
        lines.append(f"[{name}]")
        expected[name,] = len(lines)
        for key, value in table.items():
            lines.append(f"{key} = {inline(value)}")
            expected[name, key] = len(lines)
    text = "\n".join(lines)

    found = key_lines(text)

    assert set(found) == paths(tomllib.loads(text))
    assert {path: found[path] for path in expected} == expected
