"""One run on a serial counter: from arming to what is known when it is over."""

from typing import Final

import numpy as np

from drivers.h10682.detector import NAME
from drivers.h10682.handover import Handover, collect
from drivers.serial_counter.codec import bin_of, line, words_of
from drivers.serial_line import LineWire
from protocols import (
    Clock,
    CountBlock,
    CounterOverrun,
    CounterReport,
    CounterRun,
    DeviceDisconnected,
    DeviceRefused,
    DeviceTimeout,
)

_DRAIN_S: Final = 1.0
"""Longest wait for ``stopped`` behind the lines of bins that are still on their way, in seconds."""


def ask(wire: LineWire, answer: str, *words: object, limit_s: float | None = None) -> list[str]:
    """Send a line, and give the words behind ``answer``; bins that come before it are dropped.

    Raises:
        DeviceTimeout: no answer.
        DeviceRefused: the counter answers with an error.
    """

    def answers(data: bytes) -> list[str] | None:
        heard = words_of(data)
        return heard if heard and heard[0] in {answer, "error"} else None

    heard = wire.exchange(line(*words), answers, f"`{answer}`", limit_s=limit_s).value
    if heard[0] == "error":
        raise DeviceRefused(
            NAME,
            code=",".join(heard[1:]) or "error",
            saw=f"`{','.join(map(str, words))}` refused",
            expected=f"`{answer}`",
            remedy="see that the firmware keeps the protocol of docs/reference/serial-counter.md",
        )
    return heard[1:]


class SerialRun:
    """The counter from arming to disarming. Satisfies ``drivers.h10682.counter.BoardRun``."""

    def __init__(self, run: CounterRun, wire: LineWire, ticks_hz: int, clock: Clock) -> None:
        """Arm the counter.

        Raises:
            DeviceTimeout: no answer.
            DeviceRefused: it does not arm, or for another number of bins.
        """
        self._run, self._wire, self._clock = run, wire, clock
        self._handover = Handover(run.n_bins, 1 / ticks_hz)
        self._next = 0
        self._damaged = 0
        armed = ask(wire, "armed", "arm", run.n_bins)
        if armed != [str(run.n_bins)]:
            raise DeviceRefused(
                NAME,
                code=",".join(armed),
                saw=f"the counter armed for {armed} bins",
                expected=f"{run.n_bins}",
                remedy="see that the firmware keeps the protocol of docs/reference/serial-counter.md",
            )

    def read(self, timeout_s: float) -> CountBlock:
        """Hand over the bins that have closed; as ``PhotonCounter.read``."""
        return collect(self._handover, self._poll, run=self._run, clock=self._clock, timeout_s=timeout_s)

    def finish(self) -> CounterReport:
        """Stop the counter and ask how many sync edges it saw; what fails becomes a note."""
        notes, edges = self._handover.notes, None
        if self._damaged:
            notes.append(f"{self._damaged} damaged lines")
        try:
            (answer,) = ask(self._wire, "stopped", "stop", limit_s=_DRAIN_S)
            edges = int(answer)
        except (DeviceTimeout, DeviceRefused, DeviceDisconnected) as failure:
            notes.append(f"surplus sync edges are unknown: {failure}")
        except ValueError:
            notes.append("surplus sync edges are unknown: the counter does not tell their number")
        return CounterReport(bins_closed=self._handover.handed_over, edges_seen=edges, notes=tuple(notes))

    def _poll(self, _least: int) -> None:
        counts: list[int] = []
        ticks: list[int] = []
        try:
            for data in self._wire.lines():
                if self._handover.fault is not None:
                    break
                words = words_of(data)
                if words is None:
                    self._damaged += bool(data)
                elif words[0] == "overrun":
                    self._overrun()
                elif (closed := bin_of(words)) is not None:
                    if closed[0] == self._next:
                        counts.append(closed[1])
                        ticks.append(closed[2])
                        self._next += 1
                    else:
                        self._gap(closed[0])
        except DeviceDisconnected as gone:
            self._handover.fail(gone)
        self._handover.add(np.array(counts, np.uint32), np.array(ticks, np.int64))

    def _overrun(self) -> None:
        self._handover.fail(
            CounterOverrun(
                device=NAME,
                saw=f"no room in the counter's memory at bin {self._next}",
                expected="a line, and a host, that carry the bins away in time",
                remedy="lower pattern_rate_hz, or use a faster line",
            )
        )

    def _gap(self, index: int) -> None:
        self._handover.fail(
            CounterOverrun(
                device=NAME,
                saw=f"bin {index} where bin {self._next} comes next, {self._damaged} damaged lines",
                expected="every bin once, in order",
                remedy="check the cable; a line that is damaged is a bin that is lost",
            )
        )
