"""``kinopix probe``: every device of the bench, one after the other."""

import typer

from instrument.cli.options import BenchOption, JsonOption, print_json


def probe(bench: BenchOption, as_json: JsonOption = False) -> None:
    """Open each device of the bench alone, and tell who it is, what it can do, and what is doubtful. Nothing moves or is shown.

    Exits with 3 if a device does not open; the others are told all the same.
    """
    from instrument.cli.libraries import tell_libraries
    from instrument.session import probe_bench
    from instrument.views import OUT, figures_table, show_error, warn

    tell_libraries(bench, ())
    found = probe_bench(bench)
    if as_json:
        print_json({"devices": {device.role: device.as_dict() for device in found}})
    else:
        for device in found:
            if device.figures:
                OUT.print(figures_table(device.role, device.figures))
            for doubt in device.doubts:
                warn(f"{device.role}: {doubt}")
            if device.error is not None:
                show_error(device.error)
    if any(device.error is not None for device in found):
        raise typer.Exit(max(device.error.exit_code for device in found if device.error is not None))
