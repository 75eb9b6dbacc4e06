"""The error for a configuration file, which holds every mistake in it."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from protocols import InputError


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
        where = f"{place}: {self.key}" if self.key else place
        hint = f" ({self.suggestion})" if self.suggestion else ""
        return f"{where}: saw {self.saw}; expected {self.expected}{hint}"


class ConfigError(InputError):
    """A configuration file cannot be used; the error holds all its mistakes."""

    def __init__(self, file: Path, problems: Sequence[Problem]) -> None:
        """Sort the problems by line, and write one line for each."""
        self.problems = tuple(sorted(problems, key=lambda problem: problem.line or 0))
        """Mistakes in the order of the file."""
        mistakes = f"{len(problems)} mistakes" if len(problems) > 1 else "1 mistake"
        super().__init__(
            saw=f"{mistakes} in {file}",
            expected="; ".join(f"{problem.key or problem.file.name}: {problem.expected}" for problem in self.problems),
            remedy=f"correct {file}",
        )
        self.args = ("\n".join([f"{mistakes} in {file}:", *(f"  {problem}" for problem in self.problems)]),)
