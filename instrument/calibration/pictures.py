"""Runs of pictures by name, and the mean counts of each: what every measurement of the bench itself begins with."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

import numpy as np

from instrument.plan import Plan
from instrument.recording import Recording
from instrument.schemes import PicturesSettings
from instrument.session import Instrument, Listener
from protocols import Floats, InputError

_WILD: Final = 8.0
"""Deviations beyond which a count is not that of the lamp: a cosmic particle, or pick-up in a cable."""

_GAUSSIAN_MAD: Final = 1.4826


@dataclass(frozen=True)
class PictureField:
    """The pictures' field on the mirrors, and where the runs that show them are kept."""

    folder: Path
    """Folder of the recordings."""

    image_size: int = 128
    """Image pixels a side."""

    superpixel: int = 2
    """Mirrors a side of a pixel."""

    overwrite: bool = False
    """Whether recordings of the same name are replaced."""

    listeners: Sequence[Listener] = ()
    """Told of every event of every run."""

    def record(
        self,
        bench: Instrument,
        name: str,
        show: Sequence[str],
        *,
        seconds: float,
        pattern_rate_hz: float,
        each: int = 1,
    ) -> Recording:
        """Show pictures again and again for some time, in whole cycles, and give the recording.

        Args:
            bench: open, with modulator and counter.
            name: of the file, without its ending.
            show: names of the pictures.
            seconds: about how long; one cycle at least.
            pattern_rate_hz: pictures a second.
            each: how often each picture is shown before the next.

        Raises:
            KinopixError: as ``Instrument.run``.
        """
        cycle = len(show) * each
        most = bench.modulator.limits.play_order_entries - 1
        if bench.counter.limits.max_bins is not None:
            most = min(most, bench.counter.limits.max_bins)
        cycles = max(1, min(round(seconds * pattern_rate_hz / cycle), most // cycle))
        plan = Plan.model_validate(
            {
                "frames": cycles * cycle,
                "pattern_rate_hz": pattern_rate_hz,
                "image_size": self.image_size,
                "superpixel": self.superpixel,
                "scheme": {"name": "pictures", "show": tuple(show), "each": each},
            }
        )
        self.folder.mkdir(parents=True, exist_ok=True)
        out = self.folder / f"{name}.h5"
        return bench.run(plan, out, overwrite=self.overwrite, listeners=self.listeners)


@dataclass(frozen=True, eq=False)
class PictureCounts:
    """Mean counts of each picture of a cycle."""

    mean: Floats
    """``(pictures,)`` counts in one picture time; NaN where none was counted."""

    number: Floats
    """``(pictures,)`` how many pictures the mean is of."""

    picture_time_s: float
    """Time of each."""

    @property
    def rate_hz(self) -> Floats:
        """``(pictures,)`` counts a second."""
        return self.mean / self.picture_time_s

    @property
    def sigma_hz(self) -> Floats:
        """``(pictures,)`` standard deviation of the rate, as of Poisson's distribution; of one count at least."""
        time_s = self.number * self.picture_time_s
        return np.sqrt(np.maximum(self.mean * self.number, 1.0)) / time_s


def counts_of(recording: Recording, each: int, settle: int = 1, early: int = 0) -> PictureCounts:
    """Average over all cycles of a run.

    Args:
        recording: by the scheme ``pictures``.
        each: how often each picture was shown before the next.
        settle: how many of these are left out, from the first on, as they begin with light of the picture before.
        early: how many of these are left out at the end, where light may come before its edge.

    Raises:
        InputError: no whole cycle was recorded.
    """
    cycle = _cycle(recording)
    values = _counted(recording)
    cycles = len(values) // cycle
    if not cycles:
        raise InputError(
            saw=f"{len(values)} pictures", expected=f"a cycle of {cycle}", remedy="record for longer, or fewer pictures"
        )
    counts = values[: cycles * cycle].reshape(cycles, cycle // each, each)[:, :, settle : each - early]
    counts = counts.transpose(1, 0, 2).reshape(cycle // each, -1)
    middle = np.nanmedian(counts, axis=1, keepdims=True)
    spread = _GAUSSIAN_MAD * np.nanmedian(np.abs(counts - middle), axis=1, keepdims=True)
    wild = np.abs(counts - middle) > _WILD * np.maximum(spread, np.sqrt(np.maximum(middle, 1.0)))
    kept = np.where(wild, np.nan, counts)
    return PictureCounts(
        np.nanmean(kept, axis=1), np.isfinite(kept).sum(axis=1).astype(np.float64), recording.picture_time_s
    )


def together(runs: Sequence[PictureCounts]) -> PictureCounts:
    """Add up runs of the same pictures."""
    number = np.sum([run.number for run in runs], axis=0)
    total = np.sum([run.mean * run.number for run in runs], axis=0)
    return PictureCounts(total / number, number, runs[0].picture_time_s)


def _counted(recording: Recording) -> Floats:
    """``(pictures,)`` counts, NaN where they cannot be trusted. A run without any count is a dark one, as it may be meant."""
    values = recording.values[:, 0]
    if recording.frame_valid.any():
        return np.where(recording.frame_valid, values, np.nan)
    if not np.isfinite(values).all() or values.any():
        notes = "; ".join(recording.timing.notes) if recording.timing is not None else ""
        raise InputError(
            saw=f"a run of which the timing audit trusts no picture ({notes})",
            expected="sync edges and counts that belong together",
            remedy="look at the sync line, and record again",
        )
    return values


def _cycle(recording: Recording) -> int:
    """Pictures until the first is shown again."""
    settings = recording.plan.scheme
    if not isinstance(settings, PicturesSettings):
        raise InputError(
            saw=f"a recording by the scheme {settings.name}",
            expected="one by the scheme pictures",
            remedy="give a recording that kinopix calibrate has made",
        )
    return settings.cycle
