"""The documents, and what stands in them as code."""

import re
from pathlib import Path
from typing import Final

ROOT: Final = Path(__file__).parents[2]
PAGES: Final = sorted(
    path.relative_to(ROOT).as_posix()
    for folder, pattern in ((".", "*.md"), ("docs", "**/*.md"), ("benchmarks", "*.md"), ("examples", "**/*.md"))
    for path in (ROOT / folder).glob(pattern)
    if path.name != "CHANGELOG.md"  # it names what was
)

_BLOCK: Final = re.compile(r"^( *)```(\w*)\n(.*?)^ *```", re.DOTALL | re.MULTILINE)
_INLINE: Final = re.compile(r"`([^`]+)`")


def text_of(page: str) -> str:
    """Give the text of a page, by its path from the root."""
    return (ROOT / page).read_text(encoding="utf-8")


def blocks(page: str, *kinds: str) -> list[str]:
    """Give the blocks of code of some kinds, without what they are indented by; "" is the kind of those without a word."""
    found: list[tuple[str, str, str]] = _BLOCK.findall(text_of(page))
    return [
        "".join(line.removeprefix(indent) for line in body.splitlines(keepends=True))
        for indent, kind, body in found
        if kind in kinds
    ]


def command_lines(page: str, program: str) -> list[str]:
    """Give the lines of all blocks that call a program, without comments and prompts."""
    lines = [line for body in blocks(page, "", "sh", "console") for line in body.splitlines()]
    stripped = (re.split(r"\s+#", line.strip().removeprefix("$ "))[0].rstrip() for line in lines)
    return [line for line in stripped if line == program or line.startswith(f"{program} ")]


def inline_code(page: str) -> list[str]:
    """Give what stands between backticks in the text, on one line each."""
    text = _BLOCK.sub("", text_of(page))
    return [" ".join(code.split()) for code in _INLINE.findall(text)]
