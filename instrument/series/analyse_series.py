"""A series of recordings analysed. What is done is known by the analysis in the file itself, so that nothing is done twice.

An analysis is stored whole or not at all, and carries the digest of its settings and of the program. Whoever starts the same
series again, after a kill or with more recordings, has only the rest computed.
"""

import os
from collections.abc import Callable, Sequence
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import TypeAlias

from instrument.series.one_recording import Draw, Outcome, Task, analyse_one
from instrument.series.request import Request
from instrument.storage import RecordingInfo, recording_info
from instrument.workers import Failure, Job, PathMap, Where, do_missing
from protocols import InputError, KinopixError

OnRecording: TypeAlias = Callable[[Path, int, int], None]
"""Function that is called with a recording that is analysed, or failed, the number of those, and the number of all."""


@dataclass(frozen=True)
class Series:
    """What became of a series: every recording is in ``found`` or in ``failures``."""

    recordings: tuple[Path, ...]
    """All, in the order in which they were given."""

    found: dict[Path, RecordingInfo]
    """The recordings that are analysed, with their figures."""

    kept: frozenset[Path]
    """Of these, those that had been analysed so before."""

    failures: dict[Path, Failure]
    """The others, and why."""

    pictures: tuple[str, ...] = ()
    """Pictures that were drawn."""


def analyse_series(
    recordings: Sequence[str | Path],
    request: Request | None = None,
    *,
    where: Where | None = None,
    path_map: PathMap | None = None,
    results: str | Path | None = None,
    scratch: str | Path | None = None,
    pictures: str | Path | None = None,
    draw: Draw | None = None,
    again: bool = False,
    on_recording: OnRecording | None = None,
) -> Series:
    """Analyse recordings, each by itself, and store each result as soon as it is found.

    Args:
        recordings: their files, each once.
        request: how they are analysed; None takes every default.
        where: who does the work; None is this process.
        path_map: how workers call the folders of this computer; None where they call them the same.
        results: folder for copies with the analysis, named as the recordings; None writes into the recordings.
        scratch: folder of a fast disk on every worker, for recordings that lie on a slow one: each is read once.
        pictures: folder for pictures; None draws nothing.
        draw: function that draws them.
        again: whether to analyse recordings anew that have such an analysis. Copies in ``results`` are never replaced.
        on_recording: function that is called after each recording, with those that were analysed before first.

    Raises:
        InputError: two recordings would have the same name in ``results`` or ``pictures``; or as ``do_missing``.
        KeyboardInterrupt: what is analysed is kept.
    """
    every = tuple(map(Path, recordings))
    request, path_map = request or Request(), path_map or PathMap()
    targets = _targets(every, results)
    if pictures is not None:
        _targets(every, pictures)
    there = path_map.there
    sent = request
    if request.background_file is not None:
        sent = request.model_copy(update={"background_file": there(request.background_file)})
    drawn: list[str] = []

    def job(path: Path) -> Job:
        target = targets[path]
        task = Task(
            recording=there(path),
            request=sent,
            key=request.key,
            results=None if target is None else there(target),
            scratch=None if scratch is None else str(scratch),
            pictures=None if pictures is None else there(pictures),
            draw=draw,
        )
        return Job(str(path), analyse_one, (task,))

    def keep(_path: Path, outcome: Outcome) -> RecordingInfo:
        drawn.extend(outcome.pictures)
        return outcome.info

    done = do_missing(
        every,
        known=lambda path: None if again else _analysed_before(path, targets[path], request),
        job=job,
        keep=keep,
        where=where or Where(),
        on_each=on_recording,
    )
    return Series(every, done.found, done.kept, done.failures, tuple(drawn))


def _targets(recordings: Sequence[Path], folder: str | Path | None) -> dict[Path, Path | None]:
    """Give the place of each recording in a folder; None for each without one.

    Raises:
        InputError: two have the same name.
    """
    if folder is None:
        return dict.fromkeys(recordings)
    targets: dict[Path, Path | None] = {path: Path(folder) / path.name for path in recordings}
    if len(set(targets.values())) < len(targets):
        names = [path.name for path in recordings]
        twice = next(name for name in names if names.count(name) > 1)
        raise InputError(
            saw=f"several recordings with the name {twice}, and one folder {folder}",
            expected="one name for each recording",
            remedy="analyse them by folders, each with a folder of its own",
        )
    return targets


def _analysed_before(path: Path, target: Path | None, request: Request) -> RecordingInfo | None:
    """Give what is known of a recording that was analysed so before; None where it was not, or cannot be read."""
    with suppress(KinopixError, OSError):
        if target is not None and not os.path.lexists(target):
            return None
        info = recording_info(target or path)
        if info.analysis is None or info.analysis.settings.get("key") != request.key:
            return None
        if target is None or recording_info(path).start_time == info.start_time:
            return info
    return None
