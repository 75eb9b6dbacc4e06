"""Faults of the sync line (h10682-daq.md 11 and 12), as each kind of counter sees them."""

from dataclasses import replace
from typing import Final, Literal, TypedDict

from protocols import TimingFault, TriggerMissed
from tests.faults.row import Row


def _fault(line: str) -> str:
    return f"faults = [{{ {line} }}]"


class _Unknown(TypedDict):
    verdict: Literal["failed"]
    masked: Literal["all"]


_UNKNOWN: Final[_Unknown] = {"verdict": "failed", "masked": "all"}

_TIMED: Final = (
    Row(
        fault="an edge is lost",
        scene=_fault('kind = "drop-edge", picture = 100'),
        verdict="flagged",
        gaps=(100,),
        masked=(16,),
        counts="alike",
    ),
    Row(
        fault="the first edge is lost: all bins shift, and nothing tells that it was the first",
        scene=_fault('kind = "drop-edge", picture = 0'),
        error=TriggerMissed,
        says=("pmt", "239 of 240 patterns", "sync cable"),
        kept=239,
        verdict="failed",
        masked="all",
    ),
    Row(
        fault="the guard picture's edge is lost, which looks the same",
        scene=_fault('kind = "drop-edge", picture = 240'),
        error=TriggerMissed,
        says=("239 of 240 patterns",),
        kept=239,
        verdict="failed",
        masked="all",
    ),
    Row(
        fault="an edge bounces",
        scene=_fault('kind = "double-edge", picture = 100'),
        verdict="flagged",
        doubles=(100,),
        masked=(16,),
        counts="alike",
    ),
    Row(
        fault="the first edge bounces",
        scene=_fault('kind = "double-edge", picture = 0'),
        verdict="flagged",
        doubles=(0,),
        masked=(0,),
        counts="alike",
    ),
    Row(
        fault="the modulator stalls",
        scene=_fault('kind = "stall", picture = 100'),
        error=TriggerMissed,
        says=("100 of 240 patterns", "then no sync edge for 0.255 s"),
        kept=100,
        verdict="partial",
    ),
    Row(
        fault="the modulator stalls on its first picture",
        scene=_fault('kind = "stall", picture = 0'),
        error=TriggerMissed,
        says=("0 of 240 patterns",),
        kept=0,
    ),
    Row(
        fault="edges go on after the guard picture",
        scene=_fault('kind = "surplus-edges", edges = 5'),
        says=("5 sync edges after the run",),
    ),
    Row(
        fault="more edges go on than the counter has room for",
        scene=_fault('kind = "surplus-edges", edges = 50'),
        says=("50 sync edges after the run",),
    ),
    Row(
        fault="edges jitter by 200 ns",
        scene="sync_jitter_s = 2e-7",
        says=("edge jitter is",),
        counts="alike",
    ),
    Row(
        fault="edges jitter by a third of a picture",
        scene="sync_jitter_s = 1.5e-5",
        error=TriggerMissed,
        says=("of 240 patterns",),
        kept=235,
        verdict="failed",
        gaps=None,
        doubles=None,
        masked="all",
    ),
)


def _untimed(row: Row) -> Row:
    """The same fault, where nothing tells which bins it touched: all or none can be trusted."""
    if row.gaps:
        return replace(row, gaps=(), error=TriggerMissed, says=("239 of 240 patterns",), kept=239, **_UNKNOWN)
    if row.doubles:
        return replace(row, doubles=(), says=("1 surplus sync edges and no edge times",), **_UNKNOWN)
    if row.error is None:
        return replace(row, says=("surplus sync edges and no edge times",), **_UNKNOWN)
    return row if row.kept == 0 else replace(row, **_UNKNOWN)


_UNTIMED: Final = tuple(_untimed(row) for row in _TIMED[:9])

ROWS: Final = (
    *_TIMED,
    *(replace(row, fault=f"{row.fault} (NI)", counter="ni") for row in _TIMED if row.gaps or row.doubles),
    *(
        replace(row, fault=f"{row.fault} (NI analogue inputs)", counter="ni-analog", counts="alike")
        for row in (_TIMED[0], _TIMED[5])
    ),
    *(replace(row, fault=f"{row.fault} (serial counter)", counter="serial-counter") for row in (_TIMED[0], _TIMED[5])),
    *(replace(row, fault=f"{row.fault} (counter without edge times)", keys="edge_times = false") for row in _UNTIMED),
    *(replace(row, fault=f"{row.fault} (USB-CTR)", counter="usb-ctr") for row in _UNTIMED[:4]),
    Row(
        fault="edges bounce more often than the counter has room for",
        scene="faults = [" + ", ".join(f'{{ kind = "double-edge", picture = {k} }}' for k in range(0, 60, 2)) + "]",
        error=TimingFault,
        says=("258 bins that make only 228 of 240 patterns", "bounces"),
        kept=228,
        verdict="partial",
        doubles=tuple(range(0, 60, 2)),
        masked=tuple(range(10)),
        counts="alike",
    ),
    *(
        replace(row, fault=f"{row.fault} (DLP7000, NI, MC600)", modulator="alp", counter="ni", stage="mc600")
        for row in (_TIMED[0], _TIMED[3], _TIMED[5])
    ),
    *(
        replace(row, fault=f"{row.fault} (DLP7000, USB-CTR, SC300)", modulator="alp", counter="usb-ctr", stage="sc300")
        for row in (_UNTIMED[0], _UNTIMED[3], _UNTIMED[5])
    ),
    Row(
        fault="the modulator stalls (DLP7000)",
        modulator="alp",
        scene=_fault('kind = "stall", picture = 100'),
        error=TriggerMissed,
        says=("100 of 240 patterns",),
        kept=100,
        verdict="partial",
    ),
)
