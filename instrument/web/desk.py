"""Where wishes from the page wait for whoever holds the bench."""

from collections import deque
from threading import Condition
from typing import Final, Literal, TypeAlias

Wish: TypeAlias = Literal["check", "start", "stop", "home"]
"""What a page may ask for."""

WISHES: Final[tuple[Wish, ...]] = ("check", "start", "stop", "home")

_ROOM: Final = 8


class Desk:
    """Takes wishes from any thread. The thread that holds the bench takes them up; a wish to stop goes before all others."""

    def __init__(self) -> None:
        """Nobody wishes for anything."""
        self._wishes: deque[Wish] = deque()
        self._changed = Condition()
        self._rung = False

    def ask(self, wish: Wish) -> bool:
        """Put a wish down, and tell whether there was room for it. To stop takes back what was wished before."""
        with self._changed:
            if wish == "stop":
                self._wishes.clear()
            elif len(self._wishes) >= _ROOM:
                return False
            self._wishes.append(wish)
            self._changed.notify_all()
            return True

    def ring(self) -> None:
        """Wake who waits for a wish, so that it looks round."""
        with self._changed:
            self._rung = True
            self._changed.notify_all()

    def take(self, timeout_s: float) -> Wish | None:
        """Give the oldest wish; None where none came in time, or somebody rang.

        Args:
            timeout_s: how long to wait for one; 0 looks only.
        """
        with self._changed:
            self._changed.wait_for(lambda: self._wishes or self._rung, timeout_s)
            self._rung = False
            return self._wishes.popleft() if self._wishes else None
