"""``kinopix export``: a recording, with what its analysis found, for other programs."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from instrument.cli.options import JsonOption, OverwriteOption, print_json, refuse_taken

if TYPE_CHECKING:
    from protocols import Floats, Mask


def export(
    file: Annotated[Path, typer.Argument(help="Recording (.h5), whole or partial.")],
    csv: Annotated[
        bool, typer.Option("--csv", help="A line for each frame: time, values, and displacement where it was analysed.")
    ] = False,
    tiff: Annotated[
        bool, typer.Option("--tiff", help="The reconstructed image, 32-bit floating point; needs an analysis.")
    ] = False,
    npz: Annotated[bool, typer.Option("--npz", help="All arrays by name, for numpy.")] = False,
    out: Annotated[
        Path | None,
        typer.Option("--out", help="File to write; the recording's name with another end if not given."),
    ] = None,
    overwrite: OverwriteOption = False,
    as_json: JsonOption = False,
) -> None:
    """Write a recording as CSV, TIFF or NPZ. Several kinds may be asked for at once; the recording stays as it is."""
    from instrument.views import say
    from protocols import InputError

    kinds = [name for name, asked in (("csv", csv), ("tiff", tiff), ("npz", npz)) if asked]
    if not kinds or (out is not None and len(kinds) > 1):
        raise InputError(
            saw=" and ".join(f"--{kind}" for kind in kinds) + " with one --out" if kinds else "no kind of file",
            expected="--csv, --tiff or --npz; one of them where --out is given",
            remedy="correct the options",
        )
    places = {kind: out or file.with_suffix(f".{kind}") for kind in kinds}
    for place in places.values():
        refuse_taken(place, overwrite=overwrite)
    arrays = arrays_of(file)
    for kind, place in places.items():
        _WRITERS[kind](arrays, file, place)
        if not as_json:
            say(f"written {place}")
    if as_json:
        print_json({"written": {kind: str(place) for kind, place in places.items()}})


def arrays_of(file: Path) -> "dict[str, Floats | Mask]":
    """Give every array of a recording and of its analysis by name, as ``--npz`` writes them.

    Raises:
        InputError: the file cannot be read.
    """
    from dataclasses import fields

    import numpy as np

    from instrument.storage import open_recording, stored_analysis

    recording, analysis = open_recording(file), stored_analysis(file)
    times = recording.pattern_time_s.mean(axis=1)
    arrays: dict[str, Floats | Mask] = {"time_s": times, "frame_valid": recording.frame_valid}
    arrays["values"] = recording.values
    if recording.edge_time_s is not None:
        arrays["edge_time_s"] = recording.edge_time_s
    if analysis is not None:
        found = {field.name: getattr(analysis, field.name) for field in fields(analysis)}
        arrays |= {name: np.asarray(of) for name, of in found.items() if of is not None and name != "time_s"}
    if recording.truth is not None:
        arrays |= {"truth_displacement_px": recording.truth.displacement_px, "truth_image": recording.truth.image}
    return arrays


def _write_csv(arrays: "dict[str, Floats | Mask]", _file: Path, place: Path) -> None:
    """A line for each frame; columns of ``values`` are the patterns in play order, those of a path x and y."""
    import csv

    ends = {"displacement_mm": ("along_mm", "across_mm"), "sigma_mm": ("sigma_along_mm", "sigma_across_mm")}
    columns: dict[str, list[object]] = {}
    frames = len(arrays["time_s"])
    for name, array in arrays.items():
        if array.ndim == 0 or len(array) != frames or "image" in name or name in {"edge_time_s", "still", "origin_px"}:
            continue
        if array.ndim == 1:
            columns[name] = array.tolist()
            continue
        for column in range(array.shape[1]):
            axis = "xy"[column] if array.shape[1] == 2 and name != "values" else str(column)
            plain = name.replace("displacement_px", f"{axis}_px").replace("sigma_px", f"sigma_{axis}_px")
            label = ends[name][column] if name in ends else plain if plain != name else f"{name}_{axis}"
            columns[label] = array[:, column].tolist()
    with place.open("w", newline="", encoding="utf-8") as opened:
        writer = csv.writer(opened, lineterminator="\n")
        writer.writerow(["frame", *columns])
        writer.writerows([frame, *row] for frame, row in enumerate(zip(*columns.values(), strict=True)))


def _write_tiff(arrays: "dict[str, Floats | Mask]", file: Path, place: Path) -> None:
    import numpy as np
    from PIL import Image

    from protocols import InputError

    if "image" not in arrays:
        raise InputError(
            saw=f"no reconstructed image in {file}",
            expected="an analysed recording of a scheme with images",
            remedy=f"analyse it first: kinopix analyse {file}",
        )
    Image.fromarray(np.asarray(arrays["image"], np.float32)).save(place, "TIFF")


def _write_npz(arrays: "dict[str, Floats | Mask]", _file: Path, place: Path) -> None:
    import numpy as np

    with place.open("wb") as opened:  # numpy would put another end behind the name
        np.savez_compressed(opened, allow_pickle=False, **arrays)


_WRITERS = {"csv": _write_csv, "tiff": _write_tiff, "npz": _write_npz}
