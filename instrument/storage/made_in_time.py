"""A writer that is made on a disk which may not answer."""

from collections.abc import Callable
from pathlib import Path
from threading import Thread
from typing import Final

from instrument.storage.failure import no_answer
from instrument.storage.hdf5_failure import never_close
from instrument.storage.writer import RecordingWriter

PATIENCE_S: Final = 2.5
"""So long the disk may take for one call, before the run ends."""


def made_in_time(path: Path, make: Callable[[], RecordingWriter], patience_s: float = PATIENCE_S) -> RecordingWriter:
    """Make a writer on a thread of its own, as the disk may hang there too.

    Raises:
        StorageFailed: the disk does not answer.
        InputError: as ``RecordingWriter``.
    """
    made: list[RecordingWriter | BaseException] = []

    def work() -> None:
        try:
            made.append(make())
        except BaseException as error:  # noqa: BLE001 - it is raised below
            made.append(error)

    thread = Thread(target=work, name="kinopix-maker", daemon=True)
    thread.start()
    thread.join(patience_s)
    if not made:
        never_close(thread)
        raise no_answer(path, patience_s)
    if isinstance(made[0], BaseException):
        raise made[0]
    return made[0]
