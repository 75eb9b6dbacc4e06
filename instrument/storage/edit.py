"""A recording changed as a whole or not at all."""

import os
from collections.abc import Generator
from contextlib import contextmanager
from pathlib import Path

from instrument.storage.hdf5 import File, Group


@contextmanager
def rewritten(old: File, path: Path) -> Generator[Group]:
    """Give ``/entry`` of a copy of ``old``, without its analysis, and put the copy in the place of ``path`` at the end.

    One road for three needs: what is added is there whole or not at all, a file whose writer died is sound again, and the
    space of an earlier analysis is given back. ``old`` is closed at the end. If anything fails, ``path`` stays as it was.
    """
    copy = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        with File(copy, "w") as new:
            old.copy_to(new, without="entry")
            entry = new.group("entry", "NXentry")
            old.at("entry").copy_to(entry, without="analysis")
            yield entry
        with copy.open("rb+") as written:
            os.fsync(written.fileno())
        old.close()  # some systems do not replace a file that is open
        copy.replace(path)
    finally:
        copy.unlink(missing_ok=True)
