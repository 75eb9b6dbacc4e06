"""Who has the board, across processes: a killed one leaves it allocated, as a real board is until its power is cycled."""

from pathlib import Path


class Owner:
    """A file that is there while the board is allocated."""

    def __init__(self, file: Path | None) -> None:
        """Remember in ``file``, or nowhere."""
        self._file = file

    @property
    def held(self) -> bool:
        """Whether an owner, alive or not, has the board."""
        return self._file is not None and self._file.exists()

    def take(self) -> None:
        """Note that the board is allocated."""
        if self._file is not None:
            self._file.touch()

    def release(self) -> None:
        """Note that the board is free."""
        if self._file is not None:
            self._file.unlink(missing_ok=True)
