"""Attack the program by every road at once, and print one table: how often it was tried, how often it went wrong, and the worst.

A road that took more than ``MOST_GB`` of memory is not met either: the table shows the largest of this process and of those that
it began, until then.

``--short`` tries each road a few times. The generators stand in ``attack_faults``, ``attack_commands``, ``attack_disk``,
``attack_power`` and ``attack_kill``; each gives rows with ``good``. Run it from the root of the repository.
"""

import argparse
import sys
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, fields
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from typing import Any, Final, Protocol

from benchmarks.attack_commands import hostile_inputs, signals, two_writers
from benchmarks.attack_faults import faults
from protocols import MonotonicClock

if sys.platform != "win32":
    import resource

MOST_GB: Final = 2.0
"""Memory that no process may need, whatever it is attacked with."""


class Row(Protocol):
    """One attack."""

    @property
    def good(self) -> bool:
        """Whether the program took it as it should."""
        ...


@dataclass(frozen=True)
class Line:
    """One road of attack, as the table shows it."""

    road: str
    tried: int
    bad: int
    most_bad: int
    """How many may go wrong, each told as doubtful."""

    took_s: float
    most_gb: float
    """Memory of the largest process until then."""

    worst: str

    @property
    def met(self) -> bool:
        """Whether the goal is met."""
        return self.tried > 0 and self.bad <= self.most_bad and self.most_gb <= MOST_GB


Attack = Callable[[int, int], Sequence[Row]]
"""``(count, seed)`` to rows."""


def elsewhere(module: str, function: str) -> Attack:
    """An attack that another module brings; where it is not there, nothing is tried, and the table shows that."""

    def attack(count: int, seed: int) -> Sequence[Row]:
        if find_spec(f"benchmarks.{module}") is None:
            return []
        rows: Sequence[Row] = getattr(import_module(f"benchmarks.{module}"), function)(count, seed)
        return rows

    return attack


ROADS: Final[dict[str, tuple[Attack, int, int, int]]] = {
    "kill -9": (elsewhere("attack_kill", "killed"), 2, 50, 0),
    "power cut": (elsewhere("attack_power", "power_cut"), 6, 240, 0),
    "disk full": (elsewhere("attack_disk", "disk_full"), 2, 20, 0),
    "signals": (signals, 3, 60, 0),
    "two writers": (two_writers, 1, 20, 0),
    "hostile inputs": (hostile_inputs, 20, 300, 0),
    "single faults, edge times": (partial(faults, at_once=1, edge_times=True), 15, 300, 0),
    "triples of faults, edge times": (partial(faults, at_once=3, edge_times=True), 15, 300, 0),
    "single faults, no edge times": (partial(faults, at_once=1, edge_times=False), 15, 300, 0),
    "triples of faults, no edge times": (partial(faults, at_once=3, edge_times=False), 15, 300, 3),
}
"""Each road: the attack, how often in the short form and in the whole one, and how many may go wrong."""


def line_of(road: str, rows: Sequence[Row], most_bad: int, took_s: float) -> Line:
    """Sum up the rows of a road. One that went wrong and was not told as doubtful is never allowed."""
    bad = [row for row in rows if not row.good]
    untold = [row for row in bad if not getattr(row, "doubtful", False)]
    worst = _worded((untold or bad)[0]) if bad else "" if rows else "not tried: the module is not there"
    return Line(road, len(rows), len(bad), 0 if untold else most_bad, took_s, _largest_gb(), worst)


def _largest_gb() -> float:
    """Peak memory of the largest process: this one, or one that it began and waited for."""
    if sys.platform == "win32":
        return 0.0
    whose = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    kilobytes = max(resource.getrusage(who).ru_maxrss for who in whose)
    return kilobytes / (1e9 if sys.platform == "darwin" else 1e6)


def _worded(row: Any) -> str:
    return ", ".join(f"{field.name} {getattr(row, field.name)}" for field in fields(row))


def attacked(roads: Sequence[str], seed: int, *, short: bool, seconds: float) -> Iterator[Line]:
    """Go each road and give its line, until the time is over: what is left then is not tried, and the table says so."""
    clock = MonotonicClock()
    begun_s = clock.now_s()
    for road in roads:
        attack, few, many, most_bad = ROADS[road]
        went_s = clock.now_s()
        if went_s - begun_s > seconds:
            yield Line(road, 0, 0, most_bad, 0.0, 0.0, "not tried: the time was over")
            continue
        rows = attack(few if short else many, seed)
        yield line_of(road, rows, most_bad, clock.now_s() - went_s)


def main(arguments: Sequence[str] | None = None) -> int:
    """Print the table; give 1 where a goal is not met."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--short", action="store_true", help="a few of each")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--seconds", type=float, default=1800.0, help="no new road is begun after so long")
    parser.add_argument("--road", action="append", choices=list(ROADS), help="only this one; may be repeated")
    asked = parser.parse_args(arguments)
    met = True
    print(f"{'road':34} {'tried':>6} {'bad':>5} {'goal':>5} {'took s':>7} {'GB':>5}  worst")
    for line in attacked(asked.road or list(ROADS), asked.seed, short=asked.short, seconds=asked.seconds):
        worst = " ".join(line.worst.split())[:160]
        figures = f"{line.tried:6} {line.bad:5} {line.most_bad:5} {line.took_s:7.1f} {line.most_gb:5.2f}"
        print(f"{line.road:34} {figures}  {worst}", flush=True)
        met &= line.met
    return 0 if met else 1


if __name__ == "__main__":
    sys.exit(main())
