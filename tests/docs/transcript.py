"""A page whose commands are run: files are written, commands typed, and what they print is held against the page.

A block ``toml`` whose first line is ``# name.toml`` is a file; blocks ``python`` are one program, run as they come; in a block
``console`` a line that begins with ``$ kinopix`` is a command, and the lines after it are what it prints on standard output.
``...`` stands for lines that are left out. Dates, times that the machine takes, and its memory are not compared.
"""

import contextlib
import io
import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from instrument.cli.main import status
from instrument.views import terminal

_BLOCK = re.compile(r"^```(toml|python|console)\n(.*?)^```", re.DOTALL | re.MULTILINE)
_OTHER_EACH_TIME = (
    (re.compile(r"\d{4}-\d\d-\d\d"), "DATE"),
    (re.compile(r"\d{8}-\d{6}"), "TIME"),
    (re.compile(r"\d+ MB"), "N MB"),
    (re.compile(r"(│ analysis\s+│).*"), r"\1"),
)


@dataclass(frozen=True)
class Typed:
    """One command, and what the page says that it prints."""

    command: str
    shown: tuple[str, ...]


def typed(page: str) -> Iterator[Typed | tuple[str, str]]:
    """Give commands, and (kind, text) of every other block, in the order of the page."""
    for kind, text in _BLOCK.findall(page):
        if kind != "console":
            yield kind, text
            continue
        for part in re.split(r"^\$ ", text, flags=re.MULTILINE)[1:]:
            command, *shown = part.rstrip("\n").split("\n")
            yield Typed(command, tuple(shown))


def prepare(kind: str, text: str, folder: Path, names: dict[str, Any]) -> None:
    """Write a file, or run the Python of a page with the names that it has so far."""
    if kind == "python":
        exec(compile(text, "the page", "exec"), names)  # noqa: S102 - our own page
        return
    path = folder / text.split("\n", 1)[0].removeprefix("# ").split(":")[0].strip()
    path.parent.mkdir(exist_ok=True)
    path.write_text(text, encoding="utf-8")


def printed_by(command: str) -> list[str]:
    """Run a command in the folder that is the current one; give what it prints on standard output."""
    out = io.StringIO()
    ours = terminal.OUT
    width, ours.width = ours.width, 80
    try:
        with contextlib.redirect_stdout(out), contextlib.redirect_stderr(io.StringIO()) as err:
            code = status(command.split()[1:])
    finally:
        ours.width = width
    assert code == 0, f"{command}: {code}\n{err.getvalue()}"
    return [line.rstrip() for line in out.getvalue().rstrip("\n").split("\n")]


def plain(line: str) -> str:
    """A line without what is another each time, and without the width of its table."""
    for pattern, instead in _OTHER_EACH_TIME:
        line = pattern.sub(instead, line)
    return re.sub(r"\s+", " ", re.sub(r"[─━]{2,}", "-", line)).strip()


def agrees(shown: tuple[str, ...], printed: list[str]) -> bool:
    """Whether the lines of the page are those that were printed, ``...`` standing for any."""
    pattern = "".join("(?:.*\n)*" if line == "..." else re.escape(plain(line)) + "\n" for line in shown)
    return re.fullmatch(pattern, "".join(plain(line) + "\n" for line in printed)) is not None
