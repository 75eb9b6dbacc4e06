"""A program as what is at the other end of a serial line: its standard input and output are the line."""

import subprocess
from collections.abc import Sequence
from pathlib import Path
from threading import Lock, Thread


class ProcessPort:
    """The line to a program, as pyserial would give it. A thread of its own hears what the program says."""

    timeout: float | None = 0.0
    """A read waits for nothing."""

    def __init__(self, command: Sequence[str | Path], folder: Path | None = None) -> None:
        """Start the program.

        Args:
            command: the program and its arguments.
            folder: in which it starts; None is the current one.
        """
        pipe = subprocess.PIPE
        self._process = subprocess.Popen(command, stdin=pipe, stdout=pipe, cwd=folder, bufsize=0)  # noqa: S603 - the caller's
        self._heard, self._lock = b"", Lock()
        Thread(target=self._listen, daemon=True).start()

    def _listen(self) -> None:
        while self._process.stdout and (data := self._process.stdout.read(4096)):
            with self._lock:
                self._heard += data

    @property
    def in_waiting(self) -> int:
        """Bytes that can be read at once."""
        return len(self._heard)

    def read(self, size: int = 1) -> bytes:
        """Read up to ``size`` bytes."""
        with self._lock:
            data, self._heard = self._heard[:size], self._heard[size:]
        return data

    def write(self, b: bytes) -> int:
        """Write all of it."""
        return self._process.stdin.write(b) or 0 if self._process.stdin else 0

    def reset_input_buffer(self) -> None:
        """Throw away what came before."""
        with self._lock:
            self._heard = b""

    def close(self) -> None:
        """End the program; allowed twice."""
        self._process.kill()
        self._process.communicate()
