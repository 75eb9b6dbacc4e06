"""A recording changed as a whole or not at all."""

import os
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from instrument.storage import layout
from instrument.storage.hdf5 import File, Group


@contextmanager
def rewritten(old: File, path: Path) -> Generator[Group]:
    """Give ``/entry`` of a copy of ``old``, without its analysis, and put the copy in the place of ``path`` at the end.

    It serves three needs: what is added is there whole or not at all, a file whose writer died is sound again, and the
    space of an earlier analysis is given back. Whoever has ``path`` open keeps the file as it was.
    ``old`` is closed at the end. If anything fails, ``path`` stays as it was.
    """
    copy = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with File(copy, "w") as new:
            old.copy_to(new, without="entry")
            entry = new.group("entry", "NXentry")
            old.at("entry").copy_to(entry, without="analysis")
            if layout.FILE_BYTES in entry:
                entry.set_value(layout.FILE_BYTES, np.int64(0))  # as in every file that is closed well
            yield entry
        with copy.open("rb+") as written:
            os.fsync(written.fileno())
        old.close()  # some systems do not replace a file that is open
        copy.replace(path)
    finally:
        copy.unlink(missing_ok=True)
