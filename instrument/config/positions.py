"""The line of each key in a TOML text.

``tomllib`` gives the values without their lines. As the text is known to be valid, a scanner that finds keys and skips values
is enough. It knows headers, arrays of tables, dotted and quoted keys, arrays, inline tables, and all four kinds of strings.
"""

import re
import tomllib
from typing import TypeAlias

KeyPath: TypeAlias = tuple[str | int, ...]
"""Path from the root of a document: keys of tables and indices of arrays."""

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
    """Goes through a text once and notes the line of each key."""

    def __init__(self, text: str) -> None:
        self.text = text
        self.at = 0
        """Index of the next character."""
        self.line, self.counted_to = 1, 0
        """Line on which the character ``counted_to`` stands: each line break is counted once."""
        self.lines: dict[KeyPath, int] = {}
        self.last_index: dict[KeyPath, int] = {}
        """Index of the newest element of each array of tables."""

    def scan(self) -> dict[KeyPath, int]:
        """Scan the whole text."""
        table: KeyPath = ()
        while self.skip_blank() < len(self.text):
            if self.text[self.at] == "[":
                table = self.header()
            else:
                self.key_value(table)
        return self.lines

    def skip_blank(self) -> int:
        """Go on to the next character that is no blank, no line end and no comment, and give its index."""
        self.skip(_BLANK)
        return self.at

    def skip(self, pattern: re.Pattern[str]) -> re.Match[str]:
        """Go on past a match of ``pattern``, and give the match."""
        found = pattern.match(self.text, self.at)
        if found is None:
            raise ValueError(f"no valid TOML at character {self.at}")
        self.at = found.end()
        return found

    def note(self, path: KeyPath) -> None:
        """Note the current line for a path that has none yet."""
        self.line += self.text.count("\n", self.counted_to, self.at)
        self.counted_to = self.at
        if len(path) <= _DEEPEST:
            self.lines.setdefault(path, self.line)

    def key(self) -> list[str]:
        """Read a key, dotted or not, as its parts."""
        parts: list[str] = []
        while True:
            raw = self.skip(_KEY)[1]
            # A quoted key may hold escape sequences, which the parser resolves.
            parts.append(tomllib.loads(f"key = {raw}")["key"] if raw[0] in "\"'" else raw)
            if self.text[self.at] != ".":
                return parts
            self.at += 1

    def header(self) -> KeyPath:
        """Read ``[a.b]`` or ``[[a.b]]``. A part that names an array of tables stands for its newest element."""
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
        """Read a key and its value in the table at ``path``."""
        for part in self.key():
            path = (*path, part)
            self.note(path)
        self.at += 1  # past the equals sign
        self.value(path)

    def value(self, path: KeyPath) -> None:
        """Skip a value, and note the keys in it."""
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
        """Read an array, and note each element."""
        self.at += 1
        index = 0
        while self.text[self.skip_blank()] != "]":
            self.note((*path, index))
            self.value((*path, index))
            index += 1
            self.skip_comma()
        self.at += 1

    def inline_table(self, path: KeyPath) -> None:
        """Read an inline table, and note each key."""
        self.at += 1
        while self.text[self.skip_blank()] != "}":
            self.key_value(path)
            self.skip_comma()
        self.at += 1

    def skip_comma(self) -> None:
        """Go on past a comma, if there is one."""
        if self.text[self.skip_blank()] == ",":
            self.at += 1
