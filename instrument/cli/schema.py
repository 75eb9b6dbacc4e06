"""``kinopix schema``: what may stand in bench.toml and plan.toml, for editors and for readers."""

from typing import Annotated, Literal

import typer

from instrument.cli.options import print_json


def schema(
    file: Annotated[Literal["bench", "plan"], typer.Argument(help="Which file: bench.toml or plan.toml.")],
    markdown: Annotated[bool, typer.Option("--markdown", help="Print a page to read instead of JSON schema.")] = False,
) -> None:
    """Print the JSON schema of bench.toml or plan.toml, of this machine's plug-ins, or a page of all keys."""
    from instrument.config import bench_schema, keys_page, plan_schema
    from instrument.plan import Plan

    known = bench_schema() if file == "bench" else plan_schema(Plan)
    if not markdown:
        print_json(known, with_warnings=False)
        return
    typer.echo(keys_page(known, f"{file}.toml", _INTRODUCTIONS[file]), nl=False)


_INTRODUCTIONS = {
    "bench": """\
Which driver stands for each device, and its settings. `kinopix schema bench --markdown` makes this page from the program's
own models. `kinopix schema bench > bench.schema.json` writes the same for an editor, which is told by a first line
`#:schema ./bench.schema.json` in bench.toml. What the simulated bench makes of `[scene]` stands in [its own page](scene.md).""",
    "plan": """\
What is shown, how often, how fast, and how the object moves meanwhile. `kinopix schema plan --markdown` makes this page from
the program's own models. `kinopix schema plan > plan.schema.json` writes the same for an editor, which is told by a first line
`#:schema ./plan.schema.json` in plan.toml. What each scheme shows stands in [its own page](../schemes/README.md).""",
}
