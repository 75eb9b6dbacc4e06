"""The light now: the count rate of one picture, from an ordinary run whose file is not kept."""

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, Final

import numpy as np

from instrument.plan import Plan
from instrument.session.events import BlockEvent, Event
from instrument.session.instrument import Instrument
from protocols import Floats, InputError

LONGEST_S: Final = 60.0
"""Time after which counting without an end begins a new run."""

FEWEST: Final = 10
"""Pictures that are counted at least."""

_BINS: Final = 24


@dataclass(frozen=True, eq=False)
class Counting:
    """Counts of pictures that were all alike."""

    counts: Floats
    """``(n,)`` counts of each picture; those that were not counted whole are left out."""

    picture_time_s: float
    """Length of each."""

    limit_hz: float
    """Highest count rate at which the counts are linear, as the counter has it."""

    dead_time_s: float = 0.0
    """Dead time that the counter states, taken as non-paralyzable."""

    @property
    def rate_hz(self) -> float:
        """Counts a second, as they were counted; NaN without any."""
        return float(self.counts.mean()) / self.picture_time_s if len(self.counts) else float("nan")

    @property
    def sigma_hz(self) -> float:
        """Standard deviation of the rate, from the spread of the pictures; infinite for fewer than two."""
        n = len(self.counts)
        return float(self.counts.std(ddof=1)) / np.sqrt(n) / self.picture_time_s if n > 1 else float("inf")

    @property
    def light_hz(self) -> float:
        """Photons a second that would have been counted without dead time (Hamamatsu's handbook, eq. 6-2)."""
        return self.rate_hz / max(1e-9, 1 - self.rate_hz * self.dead_time_s)

    @property
    def share_of_limit(self) -> float:
        """The rate over the linear limit."""
        return self.rate_hz / self.limit_hz

    @property
    def variance_over_mean(self) -> float:
        """1 for steady light and no dead time; more where the light is unsteady."""
        mean = float(self.counts.mean()) if len(self.counts) else 0.0
        return float(self.counts.var(ddof=1)) / mean if len(self.counts) > 1 and mean > 0 else float("nan")

    def histogram(self) -> tuple[Floats, Floats]:
        """Numbers of pictures by their counts, ``(bins,)``, and the borders of the bins, ``(bins + 1,)``, in counts."""
        low, high = (float(self.counts.min()), float(self.counts.max())) if len(self.counts) else (0.0, 1.0)
        step = max(1.0, np.ceil((high - low + 1) / _BINS))
        borders = low - 0.5 + step * np.arange(int((high - low) // step) + 2)
        return np.histogram(self.counts, borders)[0].astype(np.float64), np.asarray(borders, np.float64)

    def as_dict(self) -> dict[str, Any]:
        """The figures, for JSON."""
        numbers, borders = self.histogram()
        return {
            "pictures": len(self.counts),
            "picture_time_s": self.picture_time_s,
            "rate_hz": self.rate_hz,
            "sigma_hz": self.sigma_hz,
            "light_hz": self.light_hz,
            "linear_limit_hz": self.limit_hz,
            "share_of_limit": self.share_of_limit,
            "variance_over_mean": self.variance_over_mean,
            "histogram": {"pictures": numbers.tolist(), "borders_counts": borders.tolist()},
        }


def count(
    bench: Instrument,
    seconds: float | None = None,
    *,
    picture: str = "white",
    pattern_rate_hz: float = 20_000.0,
    image_size: int = 128,
    superpixel: int = 2,
    tell: Callable[[Counting], object] = lambda _: None,
) -> Counting:
    """Count the light of one picture. It needs a modulator, whose sync edges open and close the counter's bins, and no stage.

    Args:
        bench: open, with modulator and counter.
        seconds: how long; None until the caller is interrupted.
        picture: its name.
        pattern_rate_hz: pictures a second.
        image_size: image pixels a side of the field.
        superpixel: mirrors a side of one image pixel.
        tell: called with the counts of each block that comes, on a thread of its own.

    Returns:
        All counts, but that of the first picture of each run.

    Raises:
        InputError: no such picture; a time too short for ``FEWEST`` pictures.
        KinopixError: as ``Instrument.run``.
    """
    longest_s = min(LONGEST_S, (bench.modulator.limits.play_order_entries - 1) / pattern_rate_hz)
    left_s = np.inf if seconds is None else seconds
    if not left_s * pattern_rate_hz >= FEWEST:
        raise InputError(
            saw=f"{left_s:g} s",
            expected=f"{FEWEST / pattern_rate_hz:g} s or more, {FEWEST} pictures",
            remedy="count for longer",
        )
    limits = bench.counter.limits
    counted: list[Floats] = []

    def counting(values: Floats) -> Counting:
        return Counting(values, 1 / pattern_rate_hz, limits.max_count_rate_hz, limits.dead_time_s)

    def listen(event: Event) -> None:
        if isinstance(event, BlockEvent) and event.block is not None:
            tell(counting(event.block.values[event.block.valid]))

    with TemporaryDirectory(prefix="kinopix-") as folder:
        while round(min(left_s, longest_s) * pattern_rate_hz) >= FEWEST:
            plan = Plan.model_validate(
                {
                    "frames": round(min(left_s, longest_s) * pattern_rate_hz),
                    "pattern_rate_hz": pattern_rate_hz,
                    "image_size": image_size,
                    "superpixel": superpixel,
                    "scheme": {"name": "pictures", "show": [picture]},
                }
            )
            recording = bench.run(plan, Path(folder) / "count.h5", overwrite=True, listeners=[listen])
            good = recording.values[recording.frame_valid, 0][1:]  # the first begins with light of the dark before it
            counted = [*counted, good] if np.isfinite(left_s) else []
            left_s -= plan.run_time_s
    return counting(np.concatenate(counted))
