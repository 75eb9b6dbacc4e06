"""Where the stage is, looked at while a run goes on, and never at its cost."""

from typing import Final

from instrument.recording import StageLog
from protocols import Clock, KinopixError, LinearStage, StagePosition

_EVERY_S: Final = 0.1
"""From one look to the next: a controller at 19,200 baud answers in 18 ms, which a counter's buffer bears."""

_MOST: Final = 5000  # looks a run: more are not needed for a path


class StageWatch:
    """Collects positions. A stage that does not answer is asked no more: the run does not depend on it."""

    def __init__(self, stage: LinearStage | None, clock: Clock) -> None:
        """Look at nothing yet; at nothing at all on a bench that was opened without a stage."""
        self._stage = stage
        self._clock = clock
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
        except KinopixError:
            self._answers = False
        self._next_s = self._clock.now_s() + _EVERY_S

    def look_again(self) -> None:
        """Ask again, if some time has passed since the last look."""
        if self._clock.now_s() >= self._next_s:
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
