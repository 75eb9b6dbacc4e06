"""``kinopix analyse``: follow the object, reconstruct its image, write both into the recording, draw the pictures."""

from pathlib import Path
from typing import Annotated

import typer

from instrument.analysis import Analysis, Tracking, analyse
from instrument.cli.options import JsonOption, print_json
from instrument.reconstruction import Method
from instrument.recording import Recording
from instrument.storage import open_recording, write_analysis
from instrument.views.pictures import picture_folder, write_pictures
from instrument.views.terminal import OUT, figures_table, progress, warn
from protocols import InputError


def analyse_file(
    file: Annotated[Path, typer.Argument(help="Recording (.h5), whole or partial.")],
    tracking: Annotated[
        Tracking,
        typer.Option(help="joint: refine motion and image together; smooth: one pass; per-frame: the paper's."),
    ] = "joint",
    method: Annotated[Method, typer.Option(help="How the image is made.")] = "tv",
    frames: Annotated[int | None, typer.Option(min=1, help="Use the first frames only.")] = None,
    background: Annotated[
        Path | None, typer.Option(help="Recording of the same plan without the object, to be subtracted.")
    ] = None,
    pictures: Annotated[
        Path | None, typer.Option(help="Folder for the pictures; beside the recording if not given.")
    ] = None,
    no_pictures: Annotated[bool, typer.Option("--no-pictures", help="Draw nothing.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Track and reconstruct a recording; write /entry/analysis into it, pictures beside it, and print the figures."""
    recording = open_recording(file)
    if not no_pictures:
        picture_folder(pictures or file.parent)  # asked before the work, not after
    if background is not None:
        recording = recording.minus(open_recording(background))
    analysis = analysed(recording.first(frames) if frames else recording, tracking, method)
    store(file, recording, analysis)
    drawn = [] if no_pictures else write_pictures(analysis, pictures or file.parent, file.stem)
    if as_json:
        print_json({**analysis.figures.model_dump(mode="json"), "pictures": [str(path) for path in drawn]})
        return
    OUT.print(figures_table(f"Analysis of {file.name}", analysis.figures.rows()))
    for path in drawn:
        OUT.print(f"drawn {path}", soft_wrap=True)


def analysed(recording: Recording, tracking: Tracking, method: Method) -> Analysis:
    """Analyse with a progress bar, and say what is not as it should be.

    Raises:
        InputError: no usable frame.
    """
    if not recording.frame_valid.any():
        raise InputError(
            saw=f"{len(recording)} frames, none of them valid",
            expected="a recording with usable frames",
            remedy="look at /entry/timing/report in the file for why, and repeat the run",
        )
    masked = int((~recording.frame_valid).sum())
    if masked:
        warn(f"{masked} of {len(recording)} frames are masked by the timing audit and left out")
    with progress() as bars:
        task = bars.add_task("analysis", total=None)
        analysis = analyse(
            recording,
            tracking=tracking,
            method=method,
            on_step=lambda what, done, total: bars.update(task, description=what, completed=done, total=total),
        )
    for doubt in analysis.figures.warnings():
        warn(doubt)
    return analysis


def store(file: Path, recording: Recording, analysis: Analysis) -> None:
    """Write an analysis into its recording; frames that were left out at the end are NaN there."""
    path = analysis.trajectory
    write_analysis(
        file,
        displacement_px=None if path is None else analysis.padded(path.displacement_px, len(recording)),
        sigma_px=None if path is None else analysis.padded(path.sigma_px, len(recording)),
        image=analysis.image,
        table=analysis.figures.model_dump(mode="json"),
        settings={
            "tracking": analysis.tracking,
            "method": None if analysis.reconstruction is None else analysis.reconstruction.method,
            "refinements": analysis.refinements,
            "frames": analysis.figures.frames,
        },
    )
