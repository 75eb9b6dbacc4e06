"""A TOML file: its values, and the line of each."""

import re
import tomllib
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, Final, cast

from instrument.config.errors import ConfigError, Problem
from instrument.config.positions import KeyPath, key_lines
from protocols.plain_file import read_plain

_PLACE = re.compile(r"^(.*?) \(at (?:line (\d+), column (\d+)|end of document)\)$", re.DOTALL)

MOST_BYTES: Final = 1_000_000
"""Size of a TOML file at most: a thousand times one that people write."""

_MOST_DOTS: Final = 1000  # in a line
_DEEPEST: Final = 64


@dataclass(frozen=True)
class Document:
    """The contents of a file that is valid TOML."""

    path: Path
    """Path that the file was read from."""

    values: dict[str, Any]
    """Values as ``tomllib`` gives them."""

    lines: dict[KeyPath, int]
    """Line of each key, from 1."""

    def line_of(self, path: KeyPath) -> int | None:
        """Give the line of ``path``, or of the nearest table above it that the text names; None for the whole file."""
        while path and path not in self.lines:
            path = path[:-1]
        return self.lines.get(path)

    def at(self, path: KeyPath) -> Any:
        """Give the value at ``path``; None where there is none."""
        value: Any = self.values
        for key in path:
            try:
                value = value[key]
            except (KeyError, IndexError, TypeError):
                return None
        return value


def read_document(path: Path) -> Document:
    """Read a TOML file.

    Raises:
        ConfigError: the file does not exist, is no plain file, cannot be read, is larger than ``MOST_BYTES``, is not UTF-8, or is
            not TOML.
    """
    text = _decode(path, _read(path))
    _refuse_long_keys(path, text)
    try:
        values = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise _syntax(path, text, str(error)) from error
    except ValueError as error:  # Python refuses to read thousands of digits, as that would take for ever
        raise _whole(path, "a number of more than 4300 digits", "numbers that mean something", "") from error
    except RecursionError as error:
        raise _whole(path, "brackets nested beyond all measure", "valid TOML", "") from error
    document = Document(path=path, values=values, lines=key_lines(text))
    beyond = beyond_measure(document)
    if beyond:
        raise ConfigError(path, beyond)
    return document


def beyond_measure(document: Document) -> list[Problem]:
    """Find what TOML allows but no program should be given: tables in tables without end, and whole numbers above 64 bits."""
    found: list[Problem] = []
    waiting: list[tuple[KeyPath, Any]] = [((), document.values)]
    while waiting:
        path, value = waiting.pop()
        inner: list[tuple[str | int, Any]] = []
        if isinstance(value, dict):
            inner = list(cast("dict[str | int, Any]", value).items())
        elif isinstance(value, list):
            inner = list(enumerate(cast("Sequence[Any]", value)))
        elif isinstance(value, int) and not -(2**63) <= value < 2**63:
            key = ".".join(str(part) for part in path)
            saw, expected = f"a whole number of {value.bit_length()} bits and its sign", "one that fits into 64 bits"
            found.append(Problem(document.path, document.line_of(path), key, saw, expected))
        if inner and len(path) >= _DEEPEST:
            saw, expected = "tables nested beyond all measure", f"at most {_DEEPEST} in each other"
            return [Problem(document.path, document.line_of(path), "", saw, expected)]
        waiting += [((*path, key), each) for key, each in inner]
    return found


def _refuse_long_keys(path: Path, text: str) -> None:
    """A key of 100,000 parts would keep every parser busy for minutes."""
    for number, line in enumerate(text.split("\n"), 1):
        dots = line.count(".")
        if dots > _MOST_DOTS:
            saw, expected = f"a line with {dots} dots", f"{_MOST_DOTS} at most"
            raise ConfigError(path, [Problem(path, number, "", saw, expected, "break long lists into lines")])


def _read(path: Path) -> bytes:
    """Read the bytes of a file."""
    try:
        return read_plain(path, MOST_BYTES)
    except FileNotFoundError as error:
        others = ", ".join(sorted(other.name for other in path.parent.glob("*.toml"))) or "no .toml file"
        raise _whole(path, "no such file", "a TOML file", f"{path.absolute().parent} holds {others}") from error
    except IsADirectoryError as error:
        raise _whole(path, "a folder", "a TOML file", f"name a file in it, such as {path / 'bench.toml'}") from error
    except OSError as error:  # such as no permission, or a lost network drive; on Windows also a folder
        saw = "a folder" if path.is_dir() else (error.strerror or str(error))
        raise _whole(path, saw, "a TOML file that can be read", "") from error


def _decode(path: Path, raw: bytes) -> str:
    """Decode UTF-8, with or without a byte order mark."""
    if raw.startswith((b"\xff\xfe", b"\xfe\xff")):
        raise _whole(path, "text in UTF-16", "UTF-8", "save the file again as UTF-8")
    try:
        return raw.decode("utf-8-sig")  # some editors put a byte order mark in front
    except UnicodeDecodeError as error:
        line = raw.count(b"\n", 0, error.start) + 1
        saw = f"byte 0x{raw[error.start]:02x}, which is not UTF-8"
        problem = Problem(path, line, "", saw, "UTF-8", "save the file again as UTF-8")
        raise ConfigError(path, [problem]) from error


def _syntax(path: Path, text: str, message: str) -> ConfigError:
    """Give the error for a text that is not TOML, with the line that ``tomllib`` names."""
    found = _PLACE.match(message)
    said = found[1] if found else message
    line = int(found[2]) if found and found[2] else len(text.rstrip().splitlines()) or 1
    lines = text.splitlines()
    shown = lines[line - 1].strip() if line <= len(lines) else ""
    return ConfigError(path, [Problem(path, line, "", f"{shown!r}", "valid TOML", said)])


def _whole(path: Path, saw: str, expected: str, suggestion: str) -> ConfigError:
    """Give an error that concerns the file as a whole."""
    return ConfigError(path, [Problem(path, None, "", saw, expected, suggestion)])
