"""``kinopix analyse``: follow the object, reconstruct its image, write both into the recording, draw the pictures.

Of several recordings, or of folders, each is analysed by itself: see ``analyse_series``.

What the analysis stands on is loaded when it begins, so that ``--help`` and mistakes are answered at once.
"""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, Literal

import typer

from instrument.choices import Background, Grid, Method, Normalise, Reach, Shape, Tracking
from instrument.cli.analyse_series import SeriesOptions, analyse_several
from instrument.cli.analyse_windows import in_windows, refuse_beside_window
from instrument.cli.options import (
    JsonOption,
    PathMapOption,
    SchedulerOption,
    TableOption,
    WorkersOption,
    print_json,
)

if TYPE_CHECKING:
    from instrument.analysis import Analysis
    from instrument.recording import Recording


def analyse_file(
    context: typer.Context,
    files: Annotated[
        list[Path],
        typer.Argument(metavar="FILES...", help="Recordings (.h5), whole or partial, and folders of recordings."),
    ],
    tracking: Annotated[
        Tracking,
        typer.Option(help="joint: refine motion and image together; smooth: one pass; per-frame: as published."),
    ] = "joint",
    method: Annotated[Method, typer.Option(help="How the image is made.")] = "tv",
    frames: Annotated[int | None, typer.Option(min=1, help="Use the first frames only.")] = None,
    background: Annotated[
        str,
        typer.Option(
            metavar="auto|fit|none|FILE",
            help="What stands still: found with the object where the values show it (auto), always, never; or a recording of the "
            "same plan without the object, to be subtracted.",
        ),
    ] = "auto",
    grid: Annotated[
        Grid, typer.Option(help="Image pixels to a pattern pixel's side; auto: 2 where the motion supports it.")
    ] = "auto",
    mean_filter: Annotated[
        int | None, typer.Option(min=1, help="With --tracking per-frame: coefficients averaged, 5 in the paper.")
    ] = None,
    normalise: Annotated[
        Normalise,
        typer.Option(
            help="Divide values by the total light: smoothed over frames, each frame's own as published, or off."
        ),
    ] = "auto",
    shape: Annotated[
        Shape,
        typer.Option(
            help="Whether the object slowly turns or grows: found where the values show it (auto), never, always. Takes several "
            "times as long where it does."
        ),
    ] = "auto",
    region: Annotated[
        Reach,
        typer.Option(
            help="inside: the object is in the field in most frames; wide: it passes by, and may be larger than the field: its "
            "image then reaches outside. Needs a steady lamp, and a calibrated stage. auto: wide where only that explains the "
            "values."
        ),
    ] = "auto",
    results: Annotated[
        Path | None,
        typer.Option(
            help="New file for a copy with the analysis, of several recordings a folder; they stay as they are."
        ),
    ] = None,
    pictures: Annotated[
        Path | None,
        typer.Option(
            help="Folder for the pictures; if not given, beside the file with the analysis, and of several recordings none."
        ),
    ] = None,
    kind: Annotated[
        Literal["png", "pdf", "svg"],
        typer.Option("--format", help="Kind of the pictures: PNG to look at, PDF or SVG to print."),
    ] = "png",
    no_pictures: Annotated[bool, typer.Option("--no-pictures", help="Draw nothing.")] = False,
    table: TableOption = None,
    again: Annotated[bool, typer.Option("--again", help="Several: analyse those too that have this analysis.")] = False,
    workers: WorkersOption = None,
    scheduler: SchedulerOption = None,
    path_map: PathMapOption = None,
    scratch: Annotated[
        Path | None,
        typer.Option(help="Several: folder of a fast disk; each recording is copied there first, and read only once."),
    ] = None,
    window: Annotated[
        int | None,
        typer.Option(
            min=1, help="One long recording: analyse it in windows of about so many frames, in steady memory."
        ),
    ] = None,
    window_images: Annotated[
        str,
        typer.Option(metavar="all|none|NUMBERS", help="With --window: of which windows an image is made, as 0,3,7."),
    ] = "all",
    as_json: JsonOption = False,
) -> None:
    """Track and reconstruct a recording; write /entry/analysis into it, pictures beside it, and print the figures.

    Of several recordings, or a folder, each is analysed by itself, on all cores; one that fails is named, and the rest goes on.
    After Ctrl-C or a kill the same command does what is missing.
    """
    from instrument.analysis import background_choice

    fitted, background_file = background_choice(background)
    if window is not None:
        refuse_beside_window(
            files=len(files) > 1 or files[0].is_dir(),
            tracking=tracking != "joint",
            method=method != "tv",
            frames=frames is not None,
            grid=grid != "auto",
            mean_filter=mean_filter is not None,
            normalise=normalise != "auto",
            shape=shape != "auto",
            region=region != "auto",
            table=bool(table),
            again=again,
            workers=workers is not None,
            scheduler=scheduler is not None,
            path_map=bool(path_map),
            scratch=scratch is not None,
        )
        in_windows(
            files[0],
            window,
            window_images,
            results,
            background=background,
            pictures=None if no_pictures else pictures or (results or files[0]).parent,
            kind=kind,
            as_json=as_json,
        )
        return
    options = SeriesOptions(
        workers=workers,
        scheduler=scheduler,
        path_map=path_map or (),
        scratch=scratch,
        results=results,
        pictures=None if no_pictures else pictures,
        tables=table or (),
        again=again,
        as_json=as_json,
    )
    from instrument.series import Request

    request = Request(
        tracking=tracking,
        method=method,
        frames=frames,
        background=fitted,
        background_file=None if background_file is None else str(background_file.absolute()),
        grid=grid,
        mean_filter=mean_filter,
        normalise=normalise,
        shape=shape,
        region=region,
    )
    if len(files) > 1 or files[0].is_dir() or options.several:
        analyse_several(files, request, options)
        return
    (file,) = files
    from instrument.analysis import recording_to_analyse, store
    from instrument.storage import remains_of
    from instrument.views import OUT, figures_table, picture_folder, say, warn, write_pictures

    for left in remains_of(file):
        warn(f"{left} was left behind by a program that ended early, and is removed")
    recording = recording_to_analyse(file, background_file, results)
    folder = pictures or (results or file).parent
    if not no_pictures:
        picture_folder(folder)  # asked before the work, not after
    used = recording.first(frames) if frames else recording
    analysis = analysed(used, tracking, method, fitted, grid, mean_filter, normalise, shape, region)
    _tell_idle(context, analysis)
    store(file, recording, analysis, results, key=request.key)
    drawn = [] if no_pictures else write_pictures(analysis, folder, (results or file).stem, kind)
    if as_json:
        print_json({**analysis.figures.model_dump(mode="json"), "pictures": [str(path) for path in drawn]})
        return
    OUT.print(figures_table(f"Analysis of {file.name}", analysis.figures.rows()))
    for path in drawn:
        say(f"drawn {path}")


_OF_IMAGES: Final = ("background", "grid", "method", "region", "shape")
_OF_PATHS: Final = ("mean_filter", "tracking")


def _tell_idle(context: typer.Context, analysis: "Analysis") -> None:
    """Say which of the options on the command line do nothing for the recording's scheme."""
    from instrument.views import warn

    scheme = analysis.recording.plan.scheme.name
    for found, options, why in (
        (analysis.reconstruction, _OF_IMAGES, "which makes no image"),
        (analysis.trajectory, _OF_PATHS, "which sees no position"),
    ):
        for option in options if found is None else ():
            source = context.get_parameter_source(option)
            if source is not None and source.name == "COMMANDLINE":
                warn(f"--{option.replace('_', '-')} does nothing for the scheme {scheme}, {why}")


def analysed(
    recording: "Recording",
    tracking: Tracking = "joint",
    method: Method = "tv",
    background: Background = "auto",
    grid: Grid = "auto",
    mean_filter: int | None = None,
    normalise: Normalise = "auto",
    shape: Shape = "auto",
    region: Reach = "auto",
) -> "Analysis":
    """Analyse with a progress bar, and say what is not as it should be.

    Raises:
        InputError: no usable frame.
    """
    from instrument.analysis import analyse
    from instrument.views import progress, warn

    masked = int((~recording.frame_valid).sum())
    if 0 < masked < len(recording):
        warn(f"{masked} of {len(recording)} frames are masked by the timing audit and left out")
    with progress() as bars:
        task = bars.add_task("analysis", total=None)
        analysis = analyse(
            recording,
            tracking=tracking,
            method=method,
            background=background,
            grid=grid,
            mean_filter=mean_filter,
            normalise=normalise,
            shape=shape,
            region=region,
            on_step=lambda what, done, total: bars.update(task, description=what, completed=done, total=total),
        )
    for doubt in analysis.figures.doubts:
        warn(doubt)
    return analysis
