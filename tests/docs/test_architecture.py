"""The page on the architecture is true to the code."""

import re
from pathlib import Path

import grimp
import pytest

ROOT = Path(__file__).parents[2]
PAGE = (ROOT / "docs" / "explanation" / "architecture.md").read_text(encoding="utf-8")


def arrows_of_the_page() -> dict[str, set[str]]:
    """Room to rooms that it imports, as the block ``rooms`` says."""
    (block,) = re.findall(r"```rooms\n(.*?)```", PAGE, re.DOTALL)
    lines = (line.split("->") for line in block.strip().splitlines())
    return {room.strip(): {name.strip() for name in others.split(",") if name.strip()} for room, others in lines}


@pytest.fixture(scope="module")
def arrows_of_the_code() -> dict[str, set[str]]:
    """Room to rooms that its modules import."""
    graph = grimp.build_graph("instrument", cache_dir=None)
    rooms = {child.split(".")[1] for child in graph.find_children("instrument")}
    arrows: dict[str, set[str]] = {room: set() for room in rooms}
    for module in graph.modules:
        if "." not in module:
            continue
        for imported in graph.find_modules_directly_imported_by(module):
            if "." in imported and imported.split(".")[1] != module.split(".")[1]:
                arrows[module.split(".")[1]].add(imported.split(".")[1])
    return arrows


def test_the_arrows_of_the_page_are_the_imports_of_the_code(arrows_of_the_code: dict[str, set[str]]) -> None:
    assert arrows_of_the_page() == arrows_of_the_code


def test_every_room_has_a_line_in_the_table(arrows_of_the_code: dict[str, set[str]]) -> None:
    table = PAGE.split("## The rooms of")[1].split("## Which room")[0]
    named = {
        name
        for line in table.splitlines()
        if line.startswith("| `")
        for name in re.findall(r"`(\w+)`", line.split("|")[1])
    }
    assert named == set(arrows_of_the_code)


def test_every_file_that_the_page_names_is_there() -> None:
    named = set(re.findall(r"`([\w/]+\.py)`", PAGE))
    missing = [
        name
        for name in named
        if not any((ROOT / top / name).is_file() for top in ("", "instrument")) and not _in_a_room(name)
    ]
    assert missing == []


def _in_a_room(name: str) -> bool:
    """Files that the walk names without their room."""
    return "/" not in name and any((ROOT / "instrument").glob(f"*/{name}"))
