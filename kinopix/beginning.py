"""The first moments of the command, while its libraries are loaded: an interrupt ends it in one line.

Nothing is open, nothing moves and nothing is written yet, so there is nothing to make safe. This module is loaded before every
slow one and stands on nothing of Kinopix. ``instrument.cli`` takes the signals over when the command begins.
"""

import os
import signal
from contextlib import suppress
from types import FrameType


def end_in_one_line() -> None:
    """Let Ctrl-C, a request to end and a closed terminal end the process at once, with 128 and the signal's number.

    A signal that was ignored when the process was started (``nohup``, a job in the background) stays ignored.
    """
    for number in _heard():
        if signal.getsignal(number) not in (signal.SIG_IGN, None):
            signal.signal(number, _end)


def _heard() -> list[int]:
    names = ("SIGINT", "SIGTERM", "SIGHUP")  # Windows has no SIGHUP
    return [getattr(signal, name) for name in names if hasattr(signal, name)]


def _end(number: int, _frame: FrameType | None) -> None:
    for heard in _heard():  # a second signal would otherwise be told too, between the line and the end
        signal.signal(heard, signal.SIG_IGN)
    with suppress(OSError):  # nobody may read any more
        os.write(2, b"kinopix: interrupted before anything was begun\n")
    os._exit(128 + number)  # an exception could be swallowed, or be reworded, by a library that is half loaded
