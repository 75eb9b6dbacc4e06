"""``kinopix info``: what a recording is, at once, whatever its size."""

from pathlib import Path
from typing import Annotated

import typer

from instrument.cli.options import JsonOption, print_json


def info(
    files: Annotated[
        list[Path], typer.Argument(metavar="FILE...", help="Recordings (.h5), also while they are written.")
    ],
    as_json: JsonOption = False,
) -> None:
    """Say what recordings are: when, by what, whole or partial, their plan, timing, devices and analysis."""
    from instrument.storage import RecordingInfo, recording_info
    from instrument.views import OUT, recording_table, show_error
    from protocols import InputError

    known: list[RecordingInfo] = []
    refused: list[InputError] = []
    for file in files:
        try:
            known.append(recording_info(file))
        except InputError as error:
            refused.append(error)
    if as_json:
        print_json({"recordings": [recording.model_dump(mode="json") for recording in known]})
    else:
        for recording in known:
            OUT.print(recording_table(recording))
    for refusal in refused:
        show_error(refusal)
    if refused:
        raise typer.Exit(InputError.exit_code)
