"""Questions about a plan or a recording, and their answers."""

from dataclasses import dataclass
from typing import Literal, cast

from instrument.shown import card, line
from protocols import KinopixError, PatternSequence, PlanError
from protocols.field_docs import with_fields


@dataclass(frozen=True)
class Check:
    """One question and its answer."""

    name: str
    """What was looked at, such as ``picture time``."""

    outcome: Literal["good", "warning", "error"]
    """``error`` stops a run before it starts."""

    message: str
    """The answer, with its numbers."""

    error: KinopixError | None = None
    """What ``raise_errors`` raises for it."""


@with_fields
@dataclass(frozen=True)
class CheckReport:
    """All checks of one plan on one bench."""

    checks: tuple[Check, ...]

    sequence: PatternSequence | None = None
    """The patterns, which had to be built to be checked; None where field, play order or memory do not allow it."""

    @property
    def ok(self) -> bool:
        """Whether nothing stands against the run."""
        return all(check.outcome != "error" for check in self.checks)

    def __repr__(self) -> str:
        """Say in one line how it came out."""
        warnings = sum(check.outcome == "warning" for check in self.checks)
        errors = sum(check.outcome == "error" for check in self.checks)
        counted = [f"{n} {what}{'s' * (n != 1)}" for n, what in ((errors, "error"), (warnings, "warning")) if n]
        return line("CheckReport", f"{len(self.checks)} checks", *(counted or ["all good"]))

    def _repr_html_(self) -> str:
        """Show every check in a notebook."""
        title = "Checks: nothing stands against the run" if self.ok else "Checks: the plan cannot be carried out"
        return card(title, {f"{check.name}: {check.outcome}": check.message for check in self.checks})

    def raise_errors(self) -> None:
        """Raise the error found, or one that names all where there are several.

        Raises:
            PlanError: what stands against the run.
        """
        errors = [check.error for check in self.checks if check.error is not None]
        if len(errors) == 1:
            raise errors[0]
        if errors:
            raise PlanError(
                saw="; ".join(f"{e.device + ': ' if e.device else ''}{e.saw} (expected {e.expected})" for e in errors),
                expected="a plan that this bench can carry out",
                remedy="; ".join(dict.fromkeys(e.remedy for e in errors)),
            )

    def passed(self) -> PatternSequence:
        """Give the patterns of a plan that has passed.

        Raises:
            PlanError: what stands against the run.
        """
        self.raise_errors()
        return cast("PatternSequence", self.sequence)  # only an error leaves it out
