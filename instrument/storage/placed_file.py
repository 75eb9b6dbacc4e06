"""The file of a recording on its disk: made beside its place, put there with its first block, and with room for what is to come.

HDF5 cannot be trusted after a write that failed: it crashes, or never comes back. So room on the disk is taken before HDF5 needs
it (``room.Room``), and a file that somebody has cut off is noticed before HDF5 meets it. What is in the file is the writer's.
"""

import os
from collections.abc import Callable
from pathlib import Path
from typing import Final

from instrument.storage.failure import cut_off
from instrument.storage.in_use import refuse_while_made, refuse_while_written
from instrument.storage.part import Part
from instrument.storage.place import cannot_be_written
from instrument.storage.room import Room
from protocols import InputError

_MOST_GROWTH: Final = 1 << 20
"""Most bytes by which HDF5 lengthens a file beside the numbers themselves: a chunk of each dataset, and their indices."""


class PlacedFile:
    """One file, locked as long as this program lives, and where it is."""

    def __init__(self, path: Path, *, overwrite: bool, sync: Callable[[int], object]) -> None:
        """Create it under a temporary name, empty, and leave its lock to HDF5, which fills it now.

        Args:
            path: its place; a link to a file stays one.
            overwrite: whether an older recording there may be lost.
            sync: makes a file survive a power cut, by its descriptor.

        Raises:
            InputError: another run makes ``path`` already, or the file cannot be created.
        """
        self.path = path
        """Its place, or the one beside it that it had to take."""
        self.name_taken: InputError | None = None
        """Set where another program has made a file of that name meanwhile: ``path`` is another one then."""
        self.placed = False
        """Whether it has taken its place, or tried to for the last time: from then on it is neither replaced nor removed."""
        self.sync_by: Final = sync
        """What makes a file of this run survive a power cut, by its descriptor."""
        self._overwrite = overwrite
        self._length = 0
        self._part = _claimed(path)
        try:
            self._part.unlock()
            self._room = Room(self._part.path, self._part.fileno())
        except BaseException:
            self._part.discard()
            raise

    @property
    def lies_at(self) -> Path:
        """Where it is now."""
        return self._part.path

    @property
    def _closed_here(self) -> bool:
        """Whether Windows had to close the descriptor: then nobody else may write the file either."""
        return self._part.fileno() < 0

    def let_others_read(self) -> None:
        """Lock it against other writers alone, now that everything has its place in it.

        Raises:
            OSError: somebody has removed it meanwhile.
        """
        self._part.let_others_read()

    def put_in_place(self) -> None:
        """Give it its name, or one beside it where another program has taken that.

        Raises:
            OSError: the disk failed.
        """
        try:
            if self._overwrite:
                refuse_while_written(self.path, but=self._part.path)
            self._part.put_in_place(replace=self._overwrite)
        except (FileExistsError, InputError) as error:
            # The counts are there: they are kept, and the run is told when they are.
            self.path, asked = self._part.put_beside(), self.path
            self.name_taken = InputError(
                saw=f"{asked}, which another program has made since the run began ({error})",
                expected="a place that nobody else writes to",
                remedy=f"what was counted is in {self.path}; name another file for the next run",
            )
        self.placed = True

    def take_room(self, numbers: int) -> None:
        """Make sure that HDF5 can write so many more numbers, before it begins.

        Raises:
            OSError: there is no room.
            StorageFailed: the file has lost its end.
        """
        if self._closed_here:
            return
        size = os.fstat(self._part.fileno()).st_size
        if size < self._length or self._room.lost():
            raise cut_off(self.path, size)
        self._room.take(size + 8 * numbers + _MOST_GROWTH)

    def give_room_back(self) -> None:
        """Give back what was taken beyond the end of the file."""
        if not self._closed_here:
            self._room.give_back()

    def note_length(self) -> int:
        """Look how long it is, below which it may never be found again."""
        self._length = self._part.path.stat().st_size
        return self._length

    def forget_length(self) -> None:
        """Expect no length any more: HDF5 knows that of a file that was closed."""
        self._length = 0

    def sync(self) -> None:
        """Make sure that what was written survives a power cut. Any thread may call it, also during a write.

        Raises:
            OSError: the disk failed.
        """
        if self._closed_here:
            self.sync_other(self._part.path)
        else:
            self.sync_by(self._part.fileno())

    def sync_other(self, path: Path) -> None:
        """Make sure that another file of this run survives a power cut.

        Raises:
            OSError: the disk failed.
        """
        with path.open("rb+") as file:
            self.sync_by(file.fileno())

    def release(self) -> None:
        """Take the lock away; allowed twice."""
        self._part.release()

    def discard(self) -> None:
        """Remove it, wherever it is now, and the lock."""
        self._part.discard()


def _claimed(path: Path) -> Part:
    """Create the file under its temporary name, unless another run makes ``path`` already.

    Raises:
        InputError: names the other run, or it cannot be created.
    """
    try:
        made = Part(path.resolve(), "recorded")
    except OSError as error:
        raise cannot_be_written(path, error) from error
    try:
        refuse_while_made(path, but=made.path)  # another run may have begun since that was asked
    except BaseException:
        made.discard()
        raise
    return made
