"""A TOML file: its values, and the line of each."""

import re
import tomllib
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from instrument.config.errors import ConfigError, Problem
from instrument.config.positions import KeyPath, key_lines

_PLACE = re.compile(r"^(.*?) \(at (?:line (\d+), column (\d+)|end of document)\)$", re.DOTALL)


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
        ConfigError: the file does not exist, cannot be read, is not UTF-8, or is not TOML.
    """
    text = _decode(path, _read(path))
    try:
        values = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise _syntax(path, text, str(error)) from error
    except RecursionError as error:
        raise _whole(path, "brackets nested beyond all measure", "valid TOML", "") from error
    return Document(path=path, values=values, lines=key_lines(text))


def _read(path: Path) -> bytes:
    """Read the bytes of a file."""
    try:
        return path.read_bytes()
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
