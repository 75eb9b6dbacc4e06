"""Faults of the sync line at random pictures: is a frame that the recording calls valid ever wrong, and nobody told?

A run of the same seed without faults says what every value should be. Photons scatter anew where bins have another order, so a
value is wrong where it is farther from the light of the undisturbed run than ``_SIGMAS`` standard deviations.
"""

import random
import tempfile
import traceback
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Final

import numpy as np

from instrument.config import bench_of_tables
from instrument.plan import MotionPlan, Plan
from instrument.recording import Recording
from instrument.session import Instrument
from instrument.storage import open_recording
from protocols import Floats, KinopixError, MonotonicClock

PLAN: Final = Plan(
    frames=40, image_size=16, superpixel=4, motion=MotionPlan(velocity_mm_s=5.0, acceleration_mm_s2=50.0)
)
"""240 patterns."""

_SIGMAS: Final = 8.0
_PEAK_COUNTS: Final = 2000.0
_HANGS_S: Final = 10.0


@dataclass(frozen=True)
class Row:
    """One run with its faults."""

    faults: str
    """What went wrong on the sync line."""

    wrong_frames: int
    """Frames that the recording calls valid, and whose values are not those of the undisturbed run."""

    doubtful: bool
    """Whether the run ended with an error, or its audit says anything but good, or has a note."""

    took_s: float
    """Time of the run, by the host's clock."""

    traceback: str = ""
    """An error that is none of ours."""

    @property
    def good(self) -> bool:
        """Whether no wrong frame is called valid, and the run neither broke nor hung."""
        return not self.wrong_frames and not self.traceback and self.took_s <= _HANGS_S


def faults(count: int, seed: int, *, at_once: int, edge_times: bool) -> list[Row]:
    """Carry out ``count`` runs with ``at_once`` random faults each.

    Args:
        count: of runs.
        seed: of the faults.
        at_once: faults in a run.
        edge_times: whether the counter gives the time of each edge.
    """
    _light()  # compiled loops are compiled before anything is timed
    chance = random.Random(seed)
    return [_row([_fault(chance) for _ in range(at_once)], edge_times=edge_times) for _ in range(count)]


def _fault(chance: random.Random) -> dict[str, Any]:
    """One of the kinds that ``[scene] faults`` takes."""
    picture = chance.randrange(PLAN.patterns + 1)
    kind = chance.choice(["drop-edge", "double-edge", "stall", "surplus-edges"])
    if kind == "surplus-edges":
        return {"kind": kind, "edges": chance.randrange(1, 30)}
    if kind == "double-edge":
        return {"kind": kind, "picture": picture, "after_s": chance.choice([2e-6, 1e-5, 3e-5])}
    return {"kind": kind, "picture": picture}


def _row(at: Sequence[dict[str, Any]], *, edge_times: bool) -> Row:
    clock = MonotonicClock()
    begun_s = clock.now_s()
    recording, error = recorded(list(at), edge_times=edge_times)
    strange = error is not None and not isinstance(error, KinopixError)
    return Row(
        faults=", ".join(" ".join(f"{value}" for value in fault.values()) for fault in at),
        wrong_frames=0 if recording is None else wrong_frames(recording),
        doubtful=error is not None
        or recording is None
        or recording.timing is None
        or recording.timing.verdict != "good"
        or bool(recording.timing.notes),
        took_s=clock.now_s() - begun_s,
        traceback="".join(traceback.format_exception(error)) if strange else "",
    )


def recorded(at: list[dict[str, Any]], *, edge_times: bool) -> tuple[Recording | None, Exception | None]:
    """Record a run with these faults; of one that breaks, what is kept of it and why."""
    noise = {"kind": "poisson", "peak_counts": _PEAK_COUNTS, "seed": 5}
    tables: dict[str, Any] = {
        "modulator": {"driver": "simulated"},
        "counter": {"driver": "simulated", "edge_times": edge_times},
        "stage": {"driver": "simulated"},
        "scene": {"noise": noise, "faults": at},
    }
    error: Exception | None = None
    with tempfile.TemporaryDirectory(prefix="kinopix-attack-") as name:
        out = Path(name) / "run.h5"
        try:
            with Instrument.from_config(bench_of_tables(tables, "attack")) as bench:
                bench.run(PLAN, out)
        except Exception as caught:  # noqa: BLE001 - whatever it is, it is what is looked for
            error = caught
        return (open_recording(out) if out.exists() else None), error


@cache
def _light() -> Floats:
    """``(frames, patterns)``: expected counts of the undisturbed run; photons are left out by counting far too many."""
    from instrument.session import simulate  # noqa: PLC0415 - only the first run needs it

    noise = {"kind": "poisson", "peak_counts": 1e6 * _PEAK_COUNTS / 10, "seed": 5}
    return simulate(PLAN, {"noise": noise}).values * (10 / 1e6)


def wrong_frames(recording: Recording) -> int:
    """Count the frames that the recording calls valid, and whose values are not those of the undisturbed run."""
    light = _light()[: len(recording)]
    off = np.abs(recording.values - light) > _SIGMAS * np.sqrt(light + 1.0)
    return int(np.count_nonzero(recording.frame_valid & off.any(axis=1)))
