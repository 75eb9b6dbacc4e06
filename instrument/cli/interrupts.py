"""How the command is ended from outside: by Ctrl-C, by another program, by a terminal that is closed.

The first such signal interrupts the command, once: it is raised as ``KeyboardInterrupt`` where the main thread is, the bench
is made safe and the file is closed. Whoever presses again meanwhile changes nothing, for ``PATIENCE_S``; after that, the process
ends at once.
"""

import atexit
import os
import signal
import sys
import time
from contextlib import suppress
from threading import Timer
from types import FrameType
from typing import TYPE_CHECKING, Final

if TYPE_CHECKING:
    from sys import UnraisableHookArgs

PATIENCE_S: Final = 20.0
"""So long further signals are put off: devices are told to stop, and verified, in less than half of it."""

_RAISED_AGAIN_S: Final = 0.02


class Interrupts:
    """The signals that end a command, and which of them came first."""

    def __init__(self) -> None:
        """None has come."""
        self.number: int | None = None
        """The first signal that came, which gives the exit code."""

        self.over = False
        """Whether the command has ended, so that there is nothing left to interrupt."""

        self._came_s = 0.0
        self._heard: list[int] = []

    def listen(self) -> None:
        """Hear the signals from now on, but those that were ignored when the process was started: they stay ignored."""
        for name in ("SIGINT", "SIGTERM", "SIGHUP"):
            number = getattr(signal, name, None)  # Windows has no SIGHUP
            if number is not None and signal.getsignal(number) not in (signal.SIG_IGN, None):
                signal.signal(number, self._heed)
                self._heard.append(number)
        sys.unraisablehook = self._lost
        atexit.register(self._ignore)

    def exit_code(self, code: int) -> int:
        """Give the exit code of a command that would have ended with ``code``: 128 and the signal's number where one came."""
        return code if self.number is None else 128 + self.number

    def _heed(self, number: int, _frame: FrameType | None) -> None:
        if self.number is None and not self.over:
            self.number, self._came_s = number, time.monotonic()
            raise KeyboardInterrupt
        if self.number is None:
            self.number, self._came_s = number, time.monotonic()
        elif time.monotonic() - self._came_s > PATIENCE_S:
            with suppress(OSError):
                os.write(2, b"kinopix: ended at once; look at the bench, nobody has verified that it is safe\n")
            os._exit(128 + self.number)

    def _ignore(self) -> None:
        """The last thing that Python does on request: while it clears away, a signal would end the process by itself."""
        for number in self._heard:
            signal.signal(number, signal.SIG_IGN)

    def _lost(self, unraisable: "UnraisableHookArgs") -> None:
        """Take an interrupt that was raised where nothing can be raised, such as in a destructor, and let it come again."""
        if not isinstance(unraisable.exc_value, KeyboardInterrupt) or self.number is None:
            sys.__unraisablehook__(unraisable)
            return
        number, self.number = self.number, None
        again = Timer(_RAISED_AGAIN_S, signal.raise_signal, (number,))
        again.daemon = True
        again.start()
