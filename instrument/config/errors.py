"""Every mistake in a configuration file, in one error."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from protocols import InputError


@dataclass(frozen=True)
class Problem:
    """One mistake, and where it stands."""

    file: Path
    """The file as it was named."""

    line: int | None
    """Line in the file, from 1; None where the mistake has no place in the text."""

    key: str
    """Key path, such as ``motion.velocity_mm_s``; empty for the file as a whole."""

    saw: str
    """What stands there."""

    expected: str
    """What should stand there."""

    suggestion: str = ""
    """What was probably meant, or how to go on; empty where nobody can tell."""

    def __str__(self) -> str:
        """One paragraph: ``plan.toml:7: motion.velocity: saw ...; expected ... (did you mean ...?)``."""
        place = str(self.file) if self.line is None else f"{self.file}:{self.line}"
        where = f"{place}: {self.key}" if self.key else place
        hint = f" ({self.suggestion})" if self.suggestion else ""
        return f"{where}: saw {self.saw}; expected {self.expected}{hint}"


class ConfigError(InputError):
    """A configuration file that cannot be used, with all its mistakes at once."""

    def __init__(self, file: Path, problems: Sequence[Problem]) -> None:
        """Keep the problems in the order of the file, and write one line for each."""
        self.problems = tuple(sorted(problems, key=lambda problem: problem.line or 0))
        """Every mistake found."""
        mistakes = f"{len(problems)} mistakes" if len(problems) > 1 else "1 mistake"
        super().__init__(
            saw=f"{mistakes} in {file}",
            expected="; ".join(f"{problem.key or problem.file.name}: {problem.expected}" for problem in self.problems),
            remedy=f"correct {file}",
        )
        self.args = ("\n".join([f"{mistakes} in {file}:", *(f"  {problem}" for problem in self.problems)]),)
