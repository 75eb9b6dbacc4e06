"""On which line of a TOML text each key stands.

``tomllib`` reads the values but forgets the places. The text is known to be valid when it comes here, so a scanner that finds
keys and skips values is enough: headers, arrays of tables, dotted and quoted keys, arrays, inline tables, all four strings.
"""

import re
import tomllib
from typing import TypeAlias

KeyPath: TypeAlias = tuple[str | int, ...]
"""Keys and array indices from the root down."""

_BLANK = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
_KEY = re.compile(r'[ \t]*("(?:\\.|[^"\\])*"|\'[^\']*\'|[A-Za-z0-9_-]+)[ \t]*')
_STRING = re.compile(
    r'"""(?:\\.|[^\\])*?"""(?:"{0,2})'
    r"|'''.*?'''(?:'{0,2})"
    r'|"(?:\\.|[^"\\])*"'
    r"|'[^']*'",
    re.DOTALL,
)
_BARE_VALUE = re.compile(r"[^,\]}#\n]*")

_DEEPEST = 64  # keys further down stand where the one above them stands


def key_lines(text: str) -> dict[KeyPath, int]:
    """Find the line, from 1, where each key, table and array element of a valid TOML text is first named."""
    return _Scanner(text).scan()


class _Scanner:
    def __init__(self, text: str) -> None:
        self.text = text
        self.at = 0
        self.line, self.counted_to = 1, 0
        """The line on which ``counted_to`` lies: each line break is counted once."""
        self.lines: dict[KeyPath, int] = {}
        self.last_index: dict[KeyPath, int] = {}
        """Of each array of tables, its newest element."""

    def scan(self) -> dict[KeyPath, int]:
        table: KeyPath = ()
        while self.skip_blank() < len(self.text):
            if self.text[self.at] == "[":
                table = self.header()
            else:
                self.key_value(table)
        return self.lines

    def skip_blank(self) -> int:
        self.skip(_BLANK)
        return self.at

    def skip(self, pattern: re.Pattern[str]) -> re.Match[str]:
        found = pattern.match(self.text, self.at)
        if found is None:
            raise ValueError(f"no valid TOML at character {self.at}")
        self.at = found.end()
        return found

    def note(self, path: KeyPath) -> None:
        self.line += self.text.count("\n", self.counted_to, self.at)
        self.counted_to = self.at
        if len(path) <= _DEEPEST:
            self.lines.setdefault(path, self.line)

    def key(self) -> list[str]:
        parts: list[str] = []
        while True:
            raw = self.skip(_KEY)[1]
            # A quoted key may hold escapes: let the parser undo them.
            parts.append(tomllib.loads(f"key = {raw}")["key"] if raw[0] in "\"'" else raw)
            if self.text[self.at] != ".":
                return parts
            self.at += 1

    def header(self) -> KeyPath:
        """``[a.b]`` or ``[[a.b]]``; where a part names an array of tables, its newest element is meant."""
        brackets = 2 if self.text.startswith("[[", self.at) else 1
        self.at += brackets
        parts, path = self.key(), KeyPath()
        for depth, part in enumerate(parts, 1):
            path = (*path, part)
            self.note(path)
            if brackets == 2 and depth == len(parts):
                self.last_index[path] = self.last_index.get(path, -1) + 1
            if path in self.last_index:
                path = (*path, self.last_index[path])
                self.note(path)
        self.at += brackets
        return path

    def key_value(self, path: KeyPath) -> None:
        for part in self.key():
            path = (*path, part)
            self.note(path)
        self.at += 1  # the equals sign
        self.value(path)

    def value(self, path: KeyPath) -> None:
        match self.text[self.skip_blank()]:
            case "[":
                self.array(path)
            case "{":
                self.inline_table(path)
            case '"' | "'":
                self.skip(_STRING)
            case _:
                self.skip(_BARE_VALUE)

    def array(self, path: KeyPath) -> None:
        self.at += 1
        index = 0
        while self.text[self.skip_blank()] != "]":
            self.note((*path, index))
            self.value((*path, index))
            index += 1
            self.skip_comma()
        self.at += 1

    def inline_table(self, path: KeyPath) -> None:
        self.at += 1
        while self.text[self.skip_blank()] != "}":
            self.key_value(path)
            self.skip_comma()
        self.at += 1

    def skip_comma(self) -> None:
        if self.text[self.skip_blank()] == ",":
            self.at += 1
