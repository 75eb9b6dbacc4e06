"""The displacement by many moving runs: each measured by itself, wherever there is somebody to do it, and kept when it is.

A point, which is what one run says, is kept in a folder under a digest of the run and of the program, so that whoever starts the
same calibration again, after a kill or with more runs, has only the rest measured. A copy of a recording is the same run.
"""

import hashlib
import json
import os
from collections.abc import Callable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Final

from pydantic import ValidationError

from instrument.calibration.moving_run import displacement_of_run
from instrument.config import DisplacementSection
from instrument.storage import open_recording, program, recording_info
from instrument.workers import Failure, Job, PathMap, Progress, Where, do_missing
from protocols import InputError, KinopixError

_WRONG_INPUT: Final = InputError.exit_code


def displacement_of_runs(
    recordings: Sequence[Path],
    points: Path,
    *,
    where: Where | None = None,
    path_map: PathMap | None = None,
    again: bool = False,
    on_run: Callable[[Path, int, int], None] | None = None,
) -> Progress[Path, DisplacementSection]:
    """Measure the displacement by each of several moving runs. One that fails is named, and the others go on.

    Args:
        recordings: their files, each once. Of a run that is there twice the second is one that fails.
        points: folder of what was measured before, and will be; made when there is something to keep.
        where: who does the work; None is this process.
        path_map: how workers call the folders of this computer; None where they call them the same.
        again: whether to measure anew what was measured before.
        on_run: function that is called with each run that is done, or failed, the number of those, and the number of all.

    Raises:
        InputError, KinopixError, KeyboardInterrupt: as ``do_missing``.
    """
    there = (path_map or PathMap()).there
    keys = {path: _key(path) for path in recordings}
    first = {key: path for path, key in reversed(keys.items()) if key}
    copies = {path: first[key] for path, key in keys.items() if key and first[key] != path}

    def keep(path: Path, section: DisplacementSection) -> DisplacementSection:
        if key := keys[path]:
            _write(points / f"{key}.json", section)
        return section

    done = do_missing(
        [path for path in recordings if path not in copies],
        known=lambda path: None if again or not keys[path] else _read(points / f"{keys[path]}.json"),
        job=lambda path: Job(str(path), measure_one, (there(path),)),
        keep=keep,
        where=where or Where(),
        on_each=on_run,
    )
    for path, other in copies.items():
        done.failures[path] = Failure(f"the same run as {other}, which counts once", _WRONG_INPUT)
    return done


def measure_one(path: str) -> DisplacementSection:
    """Measure the displacement by one moving run.

    Args:
        path: of the recording, as the process that measures calls it.

    Raises:
        InputError: as ``open_recording`` and ``displacement_of_run``.
    """
    return displacement_of_run(open_recording(path))


def _key(path: Path) -> str:
    """Digest of a run and of the program; empty for what is no recording, of which nothing is kept."""
    with suppress(KinopixError, OSError):
        info = recording_info(path)
        devices = {role: identity.model_dump(mode="json") for role, identity in info.devices.items()}
        plan = None if info.plan is None else info.plan.model_dump(mode="json")
        parts = [program(), info.start_time, info.end_time, info.frames, info.version, devices, plan]
        return hashlib.sha256(json.dumps(parts, sort_keys=True).encode()).hexdigest()[:32]
    return ""


def _read(path: Path) -> DisplacementSection | None:
    try:
        return DisplacementSection.model_validate_json(path.read_bytes())
    except (OSError, ValidationError):
        return None


def _write(path: Path, section: DisplacementSection) -> None:
    """Keep a point: written under another name first, and then given its own."""
    path.parent.mkdir(parents=True, exist_ok=True)
    part = path.with_suffix(f".{os.getpid()}.part")
    with part.open("wb") as file:
        file.write(section.model_dump_json().encode())
        file.flush()
        os.fsync(file.fileno())
    part.replace(path)
    for left in path.parent.glob(f"{path.stem}.*.part"):  # of a process that was killed while it wrote
        left.unlink(missing_ok=True)
