"""Where the stage is, looked at while a run goes on, and never at its cost."""

import math
from typing import Final

from instrument.recording import StageLog
from protocols import Clock, LinearStage, StagePosition

_EVERY_S: Final = 0.1
"""From one look to the next: a controller at 19,200 baud answers in 18 ms, which every counter's buffer bears."""

_SILENCE_S: Final = 2.0
"""For so long a stage that has just fallen silent may keep whoever asks it: twice as long as drivers wait by default."""

_MOST: Final = 5000  # looks a run: more are not needed for a path


class StageWatch:
    """Collects positions. A stage that does not answer is asked no more: the run does not depend on it."""

    def __init__(self, stage: LinearStage | None, clock: Clock, *, unread_s: float = math.inf) -> None:
        """Look at nothing yet.

        Args:
            stage: to ask; None on a bench that was opened without one.
            clock: of the bench.
            unread_s: for how long the counter loses nothing though nobody reads it. Where a silent stage could keep the host for
                longer, nothing is asked while the counter counts.
        """
        self._stage = stage
        self._clock = clock
        self._bears_silence = unread_s >= _SILENCE_S
        self._seen: list[StagePosition] = []
        self._start_s: float | None = None
        self._next_s = 0.0
        self._answers = True

    def look(self) -> None:
        """Ask for the position now."""
        if self._stage is None or not self._answers or len(self._seen) >= _MOST:
            return
        try:
            self.take(self._stage.position())
        except Exception:  # noqa: BLE001 - whatever a driver raises, it is no reason to end a run
            self._answers = False
        self._next_s = self._clock.now_s() + _EVERY_S

    def look_again(self) -> None:
        """Ask again while the counter counts, if it bears that and some time has passed since the last look."""
        if self._bears_silence and self._clock.now_s() >= self._next_s:
            self.look()

    def take(self, position: StagePosition) -> None:
        """Keep a position that somebody else asked for."""
        self._seen.append(position)

    def started(self) -> None:
        """Take note that the modulator starts now."""
        self._start_s = self._clock.now_s()
        self._next_s = self._start_s + _EVERY_S

    @property
    def log(self) -> StageLog | None:
        """What was seen; None where nothing was, or before the start."""
        if not self._seen or self._start_s is None:
            return None
        return StageLog.of(self._seen, self._start_s)
