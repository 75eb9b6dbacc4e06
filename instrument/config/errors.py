"""The error for a configuration file, which holds every mistake in it."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from protocols import InputError

MOST_TOLD: Final = 20
"""Mistakes that are told one by one; the others are counted."""

_LONGEST: Final = 80


def shortened(text: str) -> str:
    """As much of a text as a person wants to read."""
    return text if len(text) <= _LONGEST else text[: _LONGEST - 3] + "..."


@dataclass(frozen=True)
class Problem:
    """One mistake, with its place in the file."""

    file: Path
    """Path of the file, as the user gave it."""

    line: int | None
    """Line in the file, from 1; None where the mistake has no line."""

    key: str
    """Path of the key, such as ``motion.velocity_mm_s``; empty for the file as a whole."""

    saw: str
    """Description of what the file has there."""

    expected: str
    """Description of what it should have there."""

    suggestion: str = ""
    """What was probably meant, or what to do; empty where there is no suggestion."""

    def __str__(self) -> str:
        """Write one paragraph: ``plan.toml:7: motion.velocity: saw ...; expected ... (did you mean ...?)``."""
        place = str(self.file) if self.line is None else f"{self.file}:{self.line}"
        where = f"{place}: {shortened(self.key)}" if self.key else place
        hint = f" ({self.suggestion})" if self.suggestion else ""
        return f"{where}: saw {self.saw}; expected {self.expected}{hint}"


class ConfigError(InputError):
    """A configuration file cannot be used; the error holds its mistakes: the first ``MOST_TOLD``, and how many more there are."""

    def __init__(self, file: Path, problems: Sequence[Problem]) -> None:
        """Sort the problems by line, and write one line for each that is told."""
        self.problems = tuple(sorted(problems, key=lambda problem: problem.line or 0))
        """Mistakes in the order of the file."""
        mistakes = f"{len(problems)} mistakes" if len(problems) > 1 else "1 mistake"
        told, others = self.problems[:MOST_TOLD], len(problems) - MOST_TOLD
        more = [f"and {others} more"] if others > 0 else []
        super().__init__(
            saw=f"{mistakes} in {file}",
            expected="; ".join(
                [*(f"{problem.key or problem.file.name}: {problem.expected}" for problem in told), *more]
            ),
            remedy=f"correct {file}",
        )
        lines = [f"{mistakes} in {file}:", *(f"  {problem}" for problem in told), *(f"  {words}" for words in more)]
        self.args = ("\n".join(lines),)
