"""The wish to end a run early, from any thread, as the run meets it."""

from collections.abc import Callable
from threading import RLock

from instrument.session.errors import RunAborted


class AbortRequest:
    """Carries the first reason to the run. What can be stopped at once is stopped by whoever asks; the run does the rest."""

    def __init__(self, stop: Callable[[], None]) -> None:
        """Nobody has asked yet.

        Args:
            stop: stops what moves and shows, from any thread.
        """
        self._stop = stop
        self._why: str | None = None
        self._stopped = False
        self._closed = False
        # Held while devices are stopped, so that no late stop meets the homing, or the next run.
        self._lock = RLock()

    @property
    def why(self) -> str | None:
        """Who wanted the end; None where nobody did."""
        return self._why

    def ask(self, why: str) -> None:
        """Ask for the end. A second time, or when the run comes to rest anyway, nothing happens."""
        with self._lock:
            if self._closed or self._stopped:
                return
            self._why = self._why or why
            self._stop()
            self._stopped = True  # only now: an interrupt may have cut it short, and then it is done again

    def check(self) -> None:
        """Raise ``RunAborted`` where somebody has asked."""
        if self._why is not None:
            raise RunAborted(self._why)

    def close(self) -> None:
        """Let nobody ask any more: the run comes to rest."""
        with self._lock:
            self._closed = True
