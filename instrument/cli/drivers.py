"""``kinopix drivers``: what is installed, what is missing, what is plugged in."""

from typing import TYPE_CHECKING

import typer

from instrument.cli.options import JsonOption, print_json

if TYPE_CHECKING:
    from rich.text import Text

    from instrument.config import PluginLine

app = typer.Typer(help="List drivers, transports, scenes and schemes; look for devices.", invoke_without_command=True)


@app.callback()
def listing(context: typer.Context, as_json: JsonOption = False) -> None:
    """List every installed driver, transport, scene and scheme, with what is missing to use it."""
    if context.invoked_subcommand:
        return
    from instrument.config import list_plugins

    lines = list_plugins()
    if as_json:
        rows: list[dict[str, object]] = [
            {
                "kind": line.plugin.kind,
                "name": line.plugin.name,
                "distribution": line.plugin.distribution,
                "version": line.plugin.version,
                "summary": line.summary,
                "ready": line.availability.ready and not line.error,
                "library": line.availability.version,
                "missing": line.error or line.availability.missing,
            }
            for line in lines
        ]
        print_json({"plugins": rows})
        return
    _print_table(lines)


def _print_table(lines: "tuple[PluginLine, ...]") -> None:
    from rich.table import Table
    from rich.text import Text

    from instrument.views import OUT, plain

    table = Table(title="Plug-ins", title_justify="left")
    table.add_column("name", no_wrap=True)
    table.add_column("what it is", ratio=1)
    table.add_column("state")
    kind = ""
    for line in lines:
        if line.plugin.kind != kind:
            kind = line.plugin.kind
            table.add_section()
            table.add_row(plain(kind, "bold"), Text(), Text())
        ready = line.availability.ready and not line.error
        state = plain("ready", "green") if ready else plain("not ready", "yellow")
        table.add_row(plain(f"  {line.plugin.name}"), plain(_what(line)), state)
    OUT.print(table)
    for line in lines:
        missing = line.error or line.availability.missing
        if missing:
            _print_missing(plain(line.plugin.name, "yellow"), missing)


def _what(line: "PluginLine") -> str:
    """Summary, with the package that it came in and the library that it found, where they are news."""
    plugin = line.plugin
    news = (
        "" if plugin.distribution == "kinopix" else f"{plugin.distribution} {plugin.version}",
        line.availability.version,
    )
    told = ", ".join(part for part in news if part)
    return f"{line.summary} ({told})" if told else line.summary


def _print_missing(name: "Text", missing: str) -> None:
    """What is missing, and on a line of its own what to do."""
    from rich.text import Text

    from instrument.views import OUT, plain

    what, _, remedy = missing.partition(" To do: ")
    OUT.print(Text.assemble(name, plain(f": {what}")), soft_wrap=True)
    if remedy:
        OUT.print(plain(f"  To do: {remedy}"), soft_wrap=True)


@app.command()
def probe(as_json: JsonOption = False) -> None:
    """Look for devices on this machine. Asks nothing that could move a stage or show a pattern."""
    from instrument.config import list_plugins
    from instrument.roles import ROLES
    from instrument.views import OUT, progress, say

    roles = {role.name for role in ROLES}
    found: list[dict[str, str]] = []
    with progress() as bars:
        task = bars.add_task("looking")
        lines = [line for line in list_plugins() if line.plugin.kind in roles]
        for line in bars.track(lines, task_id=task):
            if line.error:
                continue
            for device in line.plugin.load_driver().probe():
                found.append({"kind": line.plugin.kind, "driver": line.plugin.name, "device": device})
                if not as_json:
                    say(f"{line.plugin.kind} {line.plugin.name}: {device}")
    if as_json:
        print_json({"devices": found})
    elif not found:
        OUT.print("no device found; simulated ones need none")
