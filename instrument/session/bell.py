"""A wait that Ctrl-C may break at any moment.

``threading.Condition`` and ``Event`` are written in Python: an interrupt in their midst leaves their lock released twice or
never, so that the thread that calls fails or hangs. The queue beneath this one is written in C, and is left whole.
"""

from queue import Empty, SimpleQueue


class Bell:
    """Wakes one thread that waits. Rung before anybody waits, it is heard all the same."""

    def __init__(self) -> None:
        """Nobody has rung."""
        self._rung: SimpleQueue[None] = SimpleQueue()

    def ring(self) -> None:
        """Wake whoever waits, or will."""
        if self._rung.empty():  # once is enough
            self._rung.put(None)

    def wait(self, timeout_s: float | None = None) -> bool:
        """Wait until somebody rings, and tell whether somebody did. What has changed, the caller looks up for himself."""
        try:
            self._rung.get(timeout=timeout_s)
        except Empty:
            return False
        return True
