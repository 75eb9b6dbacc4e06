"""A clock for scripts: time passes only by sleeping, and a script may look at each pause."""

from dataclasses import dataclass, field


@dataclass
class ScriptClock:
    """A ``protocols.Clock`` that keeps the pauses it was asked for."""

    time_s: float = 0.0
    pauses_s: list[float] = field(default_factory=list[float])

    def now_s(self) -> float:
        return self.time_s

    def sleep_s(self, duration_s: float) -> None:
        self.pauses_s.append(duration_s)
        self.time_s += duration_s
