"""One recording of a series, analysed by whichever process it falls to: what is computed there, and what is told of it."""

import shutil
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, TypeAlias

from instrument.analysis import Analysis, analyse, recording_to_analyse, store
from instrument.series.request import Request
from instrument.storage import RecordingInfo, put_back, recording_info, refuse_unchangeable

Draw: TypeAlias = Callable[[Analysis, Path, str], list[Path]]
"""Function that draws the pictures of an analysis into a folder, under names that begin with a text, and gives their paths."""


@dataclass(frozen=True)
class Task:
    """What a process is told. Paths are those by which that process knows the files."""

    recording: str
    """The recording."""

    request: Request
    """How it is analysed. A background file is called as that process calls it."""

    key: str
    """Digest of the request as it was made, to be stored with the analysis."""

    results: str | None = None
    """Where a copy with the analysis goes; None for the recording itself."""

    scratch: str | None = None
    """Folder of a fast disk: the recording is copied there, all of it once and in one go, and only that copy is worked on. None
    reads it where it is."""

    pictures: str | None = None
    """Folder for pictures; None draws nothing."""

    draw: Draw | None = None
    """Draws them."""


@dataclass(frozen=True)
class Outcome:
    """What is told of a recording that is analysed."""

    info: RecordingInfo
    """The file, with the figures of its analysis."""

    pictures: tuple[str, ...] = ()
    """Pictures that were drawn, as the process that drew them calls them."""


def analyse_one(task: Task) -> Outcome:
    """Analyse a recording and store the result.

    Raises:
        InputError: as ``analyse_path``.
        OSError: the scratch folder has no room, or a file cannot be read.
    """
    if task.scratch is None:
        return _analysed(task, Path(task.recording), None if task.results is None else Path(task.results))
    recording, results = Path(task.recording), None if task.results is None else Path(task.results)
    refuse_unchangeable(recording, results, content=False)
    with TemporaryDirectory(prefix="kinopix-", dir=task.scratch) as folder:
        copy = Path(folder) / recording.name
        before = recording.stat()
        shutil.copyfile(recording, copy)
        outcome = _analysed(task, copy, None)
        put_back(copy, recording, before, results)
    return outcome


def _analysed(task: Task, path: Path, results: Path | None) -> Outcome:
    request = task.request
    recording = recording_to_analyse(path, request.background_file, results)
    used = recording if request.frames is None else recording.first(request.frames)
    settings: dict[str, Any] = request.settings
    if request.background_file is not None:
        settings["background"] = "none"
    analysis = analyse(used, **settings)
    store(path, recording, analysis, results, key=task.key)
    drawn: list[Path] = []
    if task.pictures is not None and task.draw is not None:
        drawn = task.draw(analysis, Path(task.pictures), Path(task.recording).stem)
    return Outcome(recording_info(results or path), tuple(map(str, drawn)))
