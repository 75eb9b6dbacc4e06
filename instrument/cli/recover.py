"""``kinopix recover``: a recording whose program ended without closing it, made whole."""

from pathlib import Path
from typing import Annotated

import typer

from instrument.cli.options import JsonOption, print_json


def recover_file(
    file: Annotated[Path, typer.Argument(help="Recording (.h5) that was cut off, or whose counts were spilled.")],
    spill: Annotated[
        Path | None, typer.Option(help="Spill file that is neither beside the recording nor in the temporary folder.")
    ] = None,
    out: Annotated[
        Path | None, typer.Option("--out", help="New file for the result, on another disk; everything else stays.")
    ] = None,
    as_json: JsonOption = False,
) -> None:
    """Close a recording that its run could not close, and join the counts that it spilled to it."""
    from instrument.storage import recover
    from instrument.views import say, warn

    done = recover(file, spill=spill, into=out)
    if done is not None and done.lost_bytes:
        warn(f"{done.lost_bytes} bytes at the end of the spill file are no whole record, and are left out")
    if as_json:
        print_json(
            {
                "recording": str(file if done is None else done.path),
                "recovered": done is not None,
                "patterns": None if done is None else done.patterns,
                "joined": 0 if done is None else done.joined,
                "spills": [] if done is None else [str(path) for path in done.spills],
            }
        )
    elif done is None:
        say(f"{file} was closed well, and nothing is spilled beside it: there is nothing to do")
    else:
        joined = f", {done.joined} of them from {', '.join(map(str, done.spills))}" if done.spills else ""
        say(f"{done.patterns} patterns are in {done.path}{joined}")
