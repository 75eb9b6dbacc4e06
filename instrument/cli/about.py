"""What a run is about, as ``kinopix run`` is told it: options that stand above the plan's ``[run]`` table."""

from typing import TYPE_CHECKING, Annotated, TypeAlias

import typer

if TYPE_CHECKING:
    from instrument.plan import Plan

TitleOption: TypeAlias = Annotated[
    str | None, typer.Option("--title", help="Title of the recording, in place of the plan's [run] title.")
]
SampleOption: TypeAlias = Annotated[
    str | None, typer.Option("--sample", help="What is looked at, in place of the plan's [run] sample.")
]
UserOption: TypeAlias = Annotated[
    str | None, typer.Option("--user", help="Who records, in place of the plan's [run] user.")
]
NotesOption: TypeAlias = Annotated[
    str | None, typer.Option("--notes", help="What else is worth knowing, in place of the plan's [run] notes.")
]


def with_about(plan: "Plan", **given: str | None) -> "Plan":
    """Give a plan whose ``[run]`` table has what was given on the command line.

    Args:
        plan: as the file has it.
        given: ``title``, ``sample``, ``user`` and ``notes``; None leaves what the plan says.

    Raises:
        InputError: a text is too long, or no line of text.
    """
    from pydantic import ValidationError

    from instrument.config import RunTable
    from protocols import InputError

    said = {name: text for name, text in given.items() if text is not None}
    if not said:
        return plan
    before = {} if plan.run is None else plan.run.model_dump()
    try:
        return plan.model_copy(update={"run": RunTable(**before | said)})
    except ValidationError as error:
        wrong = error.errors()[0]
        raise InputError(
            saw=f"--{wrong['loc'][0]} {str(wrong['input'])[:60]!r}: {wrong['msg']}",
            expected="a text as [run] of plan.toml takes it",
            remedy="correct it",
        ) from error
