"""What the timing audit of a run found: the value, as acquisition makes it and the recording keeps it."""

from typing import Literal, Self, TypeAlias

from pydantic import NonNegativeInt, PositiveFloat

from protocols import Frozen

Verdict: TypeAlias = Literal["good", "flagged", "partial", "failed"]
"""What the audit says of a run, in a word."""


class TimingReport(Frozen):
    """The audit's result, as the recording stores it."""

    verdict: Verdict
    """``good``: every pattern in its own bin. ``flagged``: some frames are masked, the others are sure. ``partial``: the run
    ended early, and the frames until then that are not masked are sure. ``failed``: no frame can be trusted (edges are missing
    or surplus and nobody can tell where, or there is no light)."""

    patterns_expected: NonNegativeInt
    """Patterns in the play order, the guard picture not counted."""

    patterns_recorded: NonNegativeInt
    """Patterns that have a place in the recording, those without a value too."""

    bins_received: NonNegativeInt
    """Bins that the counter handed over."""

    edges_seen: NonNegativeInt | None
    """Sync edges that the counter saw; None where it cannot tell."""

    surplus_edges: NonNegativeInt | None
    """Edges after the one that closed the last pattern; None where the counter cannot tell."""

    picture_time_s: PositiveFloat
    """What the modulator keeps."""

    mean_period_s: float | None
    """Mean time from edge to edge over regular steps, on the counter's crystal; None without edge times."""

    jitter_s: float | None
    """Standard deviation of the regular steps."""

    largest_deviation_s: float | None
    """Largest distance of a regular step from the mean."""

    clock_offset_ppm: float | None
    """(mean period / picture time - 1) in parts per million: how far modulator and counter disagree about time."""

    gaps: tuple[int, ...] = ()
    """Patterns whose opening edge is missing (the first thousand)."""

    doubles: tuple[int, ...] = ()
    """Patterns in which a surplus edge came."""

    irregular: tuple[int, ...] = ()
    """Patterns of a wrong length without a missing edge."""

    slipped: tuple[tuple[int, int, int], ...] = ()
    """Frames whose values belong to other patterns, as the values themselves show: first frame, frame after the last one, and
    by how many patterns the values come late (negative: early)."""

    frames: NonNegativeInt = 0
    """Frames in the recording, whole ones."""

    frames_masked: NonNegativeInt = 0
    """Of those, frames that analysis leaves out."""

    brightest_rate_hz: float | None = None
    """Highest count rate in a bin; None for a detector that does not count photons."""

    nonlinear_patterns: NonNegativeInt = 0
    """Patterns above the detector's linear limit."""

    notes: tuple[str, ...] = ()
    """What a person should know."""

    def part(self, first: int, end: int) -> Self:
        """Give what is said of some frames, counted from the first of them; what is said of the whole run stays as it is.

        Args:
            first: first frame.
            end: frame after the last one.
        """
        frames = max(1, self.frames)
        per_frame = max(1, round(self.patterns_recorded / frames))
        low, high = first * per_frame, end * per_frame

        def inside(patterns: tuple[int, ...]) -> tuple[int, ...]:
            return tuple(pattern - low for pattern in patterns if low <= pattern < high)

        return self.model_copy(
            update={
                "gaps": inside(self.gaps),
                "doubles": inside(self.doubles),
                "irregular": inside(self.irregular),
                "slipped": tuple(
                    (max(start, first) - first, min(stop, end) - first, by)
                    for start, stop, by in self.slipped
                    if start < end and stop > first
                ),
                "frames": end - first,
            }
        )
