"""``kinopix analyse``: follow the object, reconstruct its image, write both into the recording, draw the pictures.

What the analysis stands on is loaded when it begins, so that ``--help`` and mistakes are answered at once.
"""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Final, Literal

import typer

from instrument.choices import Background, Grid, Method, Normalise, Tracking
from instrument.cli.options import JsonOption, print_json

if TYPE_CHECKING:
    from instrument.analysis import Analysis, Figures
    from instrument.recording import Recording


def analyse_file(
    context: typer.Context,
    files: Annotated[
        list[Path],
        typer.Argument(metavar="FILE...", help="Recordings (.h5), whole or partial, or folders of them."),
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
    results: Annotated[
        Path | None,
        typer.Option(
            help="New file for a copy with the analysis; the recording stays as it is. Of several recordings: a folder."
        ),
    ] = None,
    pictures: Annotated[
        Path | None, typer.Option(help="Folder for the pictures; beside the file with the analysis if not given.")
    ] = None,
    kind: Annotated[
        Literal["png", "pdf", "svg"],
        typer.Option("--format", help="Kind of the pictures: PNG to look at, PDF or SVG to print."),
    ] = "png",
    no_pictures: Annotated[bool, typer.Option("--no-pictures", help="Draw nothing.")] = False,
    as_json: JsonOption = False,
) -> None:
    """Track and reconstruct recordings; write /entry/analysis into each, pictures beside it, and print the figures.

    Of several there is one table. One that cannot be analysed is told, and keeps no other from it; the exit code is then 2.
    """
    from instrument.views import OUT, analyses_table, figures_table, say, show_error
    from protocols import InputError

    recordings = recordings_in(files)
    given = {name for name in _OF_IMAGES | _OF_PATHS if _was_given(context, name)}
    how = _How(tracking, method, frames, background, grid, mean_filter, normalise, pictures, kind, no_pictures, given)
    if len(recordings) == 1:
        (file,) = recordings
        analysis, drawn = how.carry_out(file, results)
        if as_json:
            print_json({**analysis.figures.model_dump(mode="json"), "pictures": [str(path) for path in drawn]})
            return
        OUT.print(figures_table(f"Analysis of {file.name}", analysis.figures.rows()))
        for path in drawn:
            say(f"drawn {path}")
        return
    done: list[tuple[Path, Figures, list[Path]]] = []
    refused: list[tuple[Path, InputError]] = []
    for file in recordings:
        try:
            analysis, drawn = how.carry_out(file, None if results is None else in_folder(results, file), name=True)
        except InputError as error:
            refused.append((file, error))
            continue
        done.append((file, analysis.figures, drawn))
    if as_json:
        lines = [
            {"recording": str(file), **figures.model_dump(mode="json"), "pictures": [str(path) for path in drawn]}
            for file, figures, drawn in done
        ]
        not_done = [{"recording": str(file), "error": str(error)} for file, error in refused]
        print_json({"recordings": lines, "refused": not_done})
    elif done:
        OUT.print(analyses_table([(file, figures) for file, figures, _ in done]))
    for file, why in refused:
        show_error(InputError(saw=f"{file}: {why.saw}", expected=why.expected, remedy=why.remedy))
    if refused:
        raise typer.Exit(InputError.exit_code)


_OF_IMAGES: Final = frozenset({"method", "grid", "background"})
_OF_PATHS: Final = frozenset({"tracking", "mean_filter"})


def _was_given(context: typer.Context, name: str) -> bool:
    """Whether an option stands on the command line."""
    source = context.get_parameter_source(name)
    return source is not None and source.name == "COMMANDLINE"


@dataclass(frozen=True)
class _How:
    """How recordings are analysed, as the options say."""

    tracking: Tracking
    method: Method
    frames: int | None
    background: str
    grid: Grid
    mean_filter: int | None
    normalise: Normalise
    pictures: Path | None
    kind: Literal["png", "pdf", "svg"]
    no_pictures: bool
    given: set[str]
    """Options that stand on the command line."""

    def carry_out(self, file: Path, results: Path | None, *, name: bool = False) -> "tuple[Analysis, list[Path]]":
        """Analyse one recording, store and draw what was found; give it with its pictures.

        Raises:
            InputError: as ``analysis.recording_to_analyse`` and ``analyse``.
        """
        from instrument.analysis import background_choice, recording_to_analyse, store
        from instrument.storage import remains_of
        from instrument.views import picture_folder, warn, write_pictures

        for left in remains_of(file):
            warn(f"{left} was left behind by a program that ended early, and is removed")
        fitted, background_file = background_choice(self.background)
        recording = recording_to_analyse(file, background_file, results)
        folder = self.pictures or (results or file).parent
        if not self.no_pictures:
            picture_folder(folder)  # asked before the work, not after
        used = recording.first(self.frames) if self.frames else recording
        analysis = analysed(
            used,
            self.tracking,
            self.method,
            fitted,
            self.grid,
            self.mean_filter,
            self.normalise,
            name=f"{file.name}: " if name else "",
        )
        self._tell_idle(analysis)
        store(file, recording, analysis, results)
        if self.no_pictures:
            return analysis, []
        return analysis, write_pictures(analysis, folder, (results or file).stem, self.kind)

    def _tell_idle(self, analysis: "Analysis") -> None:
        """Say which of the options given do nothing for the recording's scheme."""
        from instrument.views import warn

        scheme = analysis.recording.plan.scheme.name
        idle = {"which makes no image": _OF_IMAGES if analysis.reconstruction is None else frozenset[str]()}
        idle["which sees no position"] = _OF_PATHS if analysis.trajectory is None else frozenset()
        for why, options in idle.items():
            for option in sorted(options & self.given):
                warn(f"--{option.replace('_', '-')} does nothing for the scheme {scheme}, {why}")


def recordings_in(paths: list[Path]) -> list[Path]:
    """Give the recordings that are named, and those of folders that are named, in the order of their names.

    Raises:
        InputError: a folder without recordings.
    """
    from protocols import InputError

    found: list[Path] = []
    for path in paths:
        if not path.is_dir():
            found.append(path)
            continue
        inside = sorted(file for file in path.glob("*.h5") if file.is_file() and not file.name.startswith("."))
        if not inside:
            raise InputError(
                saw=f"no recording in {path}", expected="a folder with files .h5", remedy="name another folder"
            )
        found += inside
    return list(dict.fromkeys(found))


def in_folder(folder: Path, file: Path) -> Path:
    """Give the place of a copy of a file in a folder, which is made.

    Raises:
        InputError: the folder cannot be made.
    """
    from instrument.views import picture_folder

    return picture_folder(folder) / file.name


def analysed(
    recording: "Recording",
    tracking: Tracking = "joint",
    method: Method = "tv",
    background: Background = "auto",
    grid: Grid = "auto",
    mean_filter: int | None = None,
    normalise: Normalise = "auto",
    *,
    name: str = "",
) -> "Analysis":
    """Analyse with a progress bar, and say what is not as it should be.

    Raises:
        InputError: no usable frame.
    """
    from instrument.analysis import analyse
    from instrument.views import progress, warn

    masked = int((~recording.frame_valid).sum())
    if 0 < masked < len(recording):
        warn(f"{name}{masked} of {len(recording)} frames are masked by the timing audit and left out")
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
            on_step=lambda what, done, total: bars.update(task, description=what, completed=done, total=total),
        )
    for doubt in analysis.figures.doubts:
        warn(f"{name}{doubt}")
    return analysis
