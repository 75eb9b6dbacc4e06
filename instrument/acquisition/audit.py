"""The timing audit: what the hardware's own edges say of a run."""

from typing import TYPE_CHECKING, Final

import numpy as np

from instrument.acquisition.alignment import AlignedBlock
from instrument.acquisition.slip_watch import SlipWatch
from instrument.recording import TimingReport
from instrument.schemes import Scheme
from protocols import CounterReport, Floats, Integers, Mask

if TYPE_CHECKING:
    from instrument.measurement import Slips

JITTER_WARNING: Final = 0.001
"""Standard deviation of the edge period, in periods, above which a note is made (50 ns at 20 kHz)."""

CLOCK_WARNING_PPM: Final = 100.0
"""Offset between the mean period and the picture time above which a note is made: another picture time, or a bad crystal."""

_WHOLE: Final = 0.1  # of a period, by which a pattern that was counted whole may be longer or shorter
_LISTED: Final = 1000  # indices kept of each kind: a broken cable makes one gap a pattern
_NOTES: Final = 50  # notes kept of a counter: a bad cable may give it one for each packet


class TimingAudit:
    """Adds up what blocks tell, in constant memory but for the mask: one byte a frame."""

    def __init__(
        self,
        *,
        patterns: int,
        patterns_per_frame: int,
        picture_time_s: float,
        max_count_rate_hz: float,
        scheme: Scheme | None = None,
    ) -> None:
        """Expect so many patterns of that length.

        Args:
            patterns: in the play order, without the guard picture.
            patterns_per_frame: of the scheme.
            picture_time_s: as the modulator keeps it.
            max_count_rate_hz: the detector's linear limit.
            scheme: by which the values themselves show where they slipped; None looks at the edges alone.
        """
        self._scheme = scheme
        self._watch = None if scheme is None else SlipWatch(scheme, patterns, patterns_per_frame)
        self._patterns = patterns
        self._per_frame = patterns_per_frame
        self._period_s = picture_time_s
        self._limit_hz = max_count_rate_hz
        self._whole = np.ones(-(-patterns // patterns_per_frame), bool)  # of each frame, all that came so far
        self._recorded = 0
        self._bins = 0
        self._beyond = 0
        self._light = 0.0
        self._doubts: list[str] = []
        self._broke_off = False
        self._found: dict[str, list[int]] = {"gaps": [], "doubles": [], "irregular": []}
        self._disorder: set[str] = set()
        self._latest_edge_s = -np.inf
        self._last_edge_s = np.nan
        self._steps = 0
        self._sum = 0.0
        self._sum_squares = 0.0
        self._extremes = (np.inf, -np.inf)
        self._brightest = 0.0
        self._nonlinear = 0
        self._photons = False

    def see(self, block: AlignedBlock, *, bins: int, photon_counts: bool) -> None:
        """Take in the next block; ``bins`` is how many bins it was made of."""
        end = block.first_pattern + len(block.values)
        self._beyond += block.beyond
        self._light += float(np.nansum(block.values))
        self._mask(block.first_pattern + np.flatnonzero(~block.valid))
        self._recorded, self._bins = end, self._bins + bins
        self._photons = photon_counts
        for name, where in (("gaps", block.gaps), ("doubles", block.doubles), ("irregular", block.irregular)):
            room = _LISTED - len(self._found[name])
            self._found[name].extend(int(k) for k in where[:room])
        if block.edge_time_s is not None:
            self._refuse_disorder(block.edge_time_s, block.gaps - block.first_pattern)
            self._mask_cut(block.first_pattern, block.edge_time_s)
            self._see_edges(block.edge_time_s)
        if self._watch is not None:
            self._watch.see(block.values, self._whole, photon_counts=photon_counts)
        if photon_counts and bool(np.any(block.valid)):
            lit = block.values[block.valid]
            self._brightest = max(self._brightest, float(lit.max()))
            self._nonlinear += int(np.count_nonzero(lit > self._limit_hz * self._period_s))

    def _refuse_disorder(self, edge_time_s: Floats, gaps: Integers) -> None:
        """Distrust a counter whose edge times are no numbers where an edge was seen, or go back: nothing they tell is sure."""
        seen = np.ones(len(edge_time_s), bool)
        seen[gaps[(gaps >= 0) & (gaps < len(seen))]] = False
        known = edge_time_s[np.isfinite(edge_time_s)]
        if not np.isfinite(edge_time_s[seen]).all():
            self._disorder.add("edge times that are no numbers")
        if bool(np.any(np.diff(known, prepend=self._latest_edge_s) <= 0)):
            self._disorder.add("edge times that go back")
        if len(known):
            self._latest_edge_s = max(self._latest_edge_s, float(known.max()))

    def _mask_cut(self, first_pattern: int, edge_time_s: Floats) -> None:
        """Mask the patterns that ended early or late, as before a bounce so late that it passed for the next edge."""
        steps = np.diff(edge_time_s, prepend=self._last_edge_s) / self._period_s
        ended = first_pattern + np.flatnonzero(np.abs(steps - 1) > _WHOLE)  # NaN compares false: gaps drop out
        self._mask(ended[ended > 0] - 1)

    def _mask(self, patterns: Integers) -> None:
        self._whole[patterns // self._per_frame] = False

    def _see_edges(self, edge_time_s: Floats) -> None:
        steps = np.diff(edge_time_s, prepend=self._last_edge_s) - self._period_s
        steps = steps[np.abs(steps) < self._period_s / 4]  # NaN compares false: gaps drop out
        if len(steps):
            self._steps += len(steps)
            self._sum += float(steps.sum())
            self._sum_squares += float(steps @ steps)
            low, high = self._extremes
            self._extremes = min(low, float(steps.min())), max(high, float(steps.max()))
        if len(edge_time_s):
            self._last_edge_s = float(edge_time_s[-1])

    @property
    def recorded(self) -> int:
        """Patterns that have a place so far."""
        return self._recorded

    @property
    def timed(self) -> bool:
        """Whether there are edge times, so that a lost or surplus edge shows where it was."""
        return self._steps > 0

    def distrust(self, why: str) -> None:
        """Mask every frame: ``why`` says what may be wrong with any of them."""
        self._doubts.append(why)

    def edges_stayed_away(self) -> None:
        """Take note that the run ended because edges were missing: no count of edges tells then whether the first one came."""
        self._broke_off = True

    def _first_edge_is_doubtful(self, counter: CounterReport) -> bool:
        """Whether the first edge may be lost as well, and too few frames were counted for their values to tell.

        The first edge is the one that no step shows. Its witnesses are a whole count of edges, and the values themselves.
        """
        if self._scheme is None or self._scheme.image_rows is None or not self.timed:
            return False
        complete = self._recorded >= self._patterns
        if not (self._broke_off or (complete and self._surplus(counter))):
            return False
        from instrument.measurement import FEWEST_FRAMES

        return self._recorded // self._per_frame < FEWEST_FRAMES

    def frame_valid(self, counter: CounterReport) -> Mask:
        """``(frames,)``: whether each frame recorded so far is good; one that was begun and not ended is not.

        Args:
            counter: what the counter told when it was disarmed.
        """
        frames = -(-self._recorded // self._per_frame)
        if self._all_doubts(counter):
            return np.zeros(frames, bool)
        valid = self._by_edges(frames)
        slips = self._slips()
        if slips is not None and slips.any:
            valid[: len(slips.sure)] &= slips.sure & (slips.shift == 0)
        return valid

    def _by_edges(self, frames: int) -> Mask:
        """``(frames,)``: whether all patterns of a frame were counted alone and whole, as far as edges tell."""
        valid = self._whole[:frames].copy()
        valid[self._recorded // self._per_frame :] = False
        return valid

    def _slips(self) -> "Slips | None":
        """What the values of the whole frames recorded so far say of their alignment; None without a scheme."""
        return None if self._watch is None else self._watch.slips(self._whole, photon_counts=self._photons)

    def report(self, counter: CounterReport) -> TimingReport:
        """Give the audit of what was seen so far. Asking changes nothing.

        Args:
            counter: what the counter told when it was disarmed.
        """
        timed = self.timed
        mean = self._sum / self._steps if timed else 0.0
        jitter = float(np.sqrt(max(0.0, self._sum_squares / self._steps - mean**2))) if timed else None
        offset_ppm = mean / self._period_s * 1e6 if timed else None
        complete = self._recorded >= self._patterns
        frames = self._recorded // self._per_frame
        valid = self.frame_valid(counter)[:frames]
        doubts = self._all_doubts(counter)
        flagged = any(self._found.values()) or not valid.all()
        return TimingReport(
            verdict="failed" if doubts else "partial" if not complete else "flagged" if flagged else "good",
            patterns_expected=self._patterns,
            patterns_recorded=self._recorded,
            bins_received=self._bins,
            edges_seen=counter.edges_seen,
            surplus_edges=self._surplus(counter),
            picture_time_s=self._period_s,
            mean_period_s=self._period_s + mean if timed else None,
            jitter_s=jitter,
            largest_deviation_s=max(abs(e - mean) for e in self._extremes) if timed else None,
            clock_offset_ppm=offset_ppm,
            gaps=tuple(self._found["gaps"]),
            doubles=tuple(self._found["doubles"]),
            irregular=tuple(self._found["irregular"]),
            slipped=self._slipped(),
            frames=frames,
            frames_masked=int(np.count_nonzero(~valid)),
            brightest_rate_hz=self._brightest / self._period_s if self._photons else None,
            nonlinear_patterns=self._nonlinear,
            notes=tuple(self._notes(counter, doubts, jitter, offset_ppm)),
        )

    def _slipped(self) -> tuple[tuple[int, int, int], ...]:
        slips = self._slips()
        if slips is None or not slips.any:
            return ()
        return tuple((part.first_frame, part.end_frame, part.shift) for part in slips.segments[:_LISTED] if part.shift)

    def _surplus(self, counter: CounterReport) -> int | None:
        """Sync edges that belong to no bin of the run; None where the counter cannot tell."""
        if counter.edges_seen is None:
            return None
        return max(0, counter.edges_seen - 1 - (self._bins - self._beyond))

    def _all_doubts(self, counter: CounterReport) -> list[str]:
        """What makes every frame doubtful: what was told before, and what the whole run shows."""
        doubts = [*self._doubts, *(f"the counter gave {what}" for what in sorted(self._disorder))]
        surplus = self._surplus(counter)
        if counter.shifted:
            doubts.append("the counter's bins may have shifted against the edges")
        if self._recorded >= self._patterns and surplus and not self.timed:
            doubts.append(f"{surplus} surplus sync edges and no edge times to tell when they came")
        if self._first_edge_is_doubtful(counter):
            doubts.append(
                "sync edges were lost or came after the run, and too few frames tell whether the first was lost"
            )
        if self._photons and self._recorded and not self._light:
            doubts.append("not one photon in the whole run: look at the light, the head's supply and the photon cable")
        return doubts

    def _notes(
        self, counter: CounterReport, doubts: list[str], jitter_s: float | None, offset_ppm: float | None
    ) -> list[str]:
        notes = list(counter.notes[:_NOTES])
        if len(counter.notes) > _NOTES:
            notes.append(f"{len(counter.notes) - _NOTES} more notes of the counter are left out")
        notes += [f"no frame can be trusted: {doubt}" for doubt in doubts]
        if self._recorded < self._patterns and not doubts:
            good = int(np.count_nonzero(self.frame_valid(counter)))
            notes.append(f"the run ended early; {good} of its {self._patterns // self._per_frame} frames are good")
        slips = self._slips()
        if slips is not None:
            from instrument.measurement import tell_slips

            notes += [f"by the counts themselves, {found.text}" for found in tell_slips(slips)]
        most_s = JITTER_WARNING * self._period_s
        if jitter_s is not None and jitter_s > most_s:
            notes.append(
                f"edge jitter is {jitter_s * 1e9:.0f} ns, above {most_s * 1e9:.0f} ns: bins differ in length by that much"
            )
        if offset_ppm is not None and abs(offset_ppm) > CLOCK_WARNING_PPM:
            notes.append(f"the counter measures a period {offset_ppm:+.0f} ppm off the modulator's picture time")
        surplus = self._surplus(counter)
        if surplus and self._recorded >= self._patterns and self.timed:
            notes.append(
                f"{surplus} sync edges after the run: something else triggers on the sync line; if that, or a lost first edge, "
                "came before the first picture, every pattern is displaced: compare the light with that of another run"
            )
        if self._nonlinear:
            notes.append(f"{self._nonlinear} patterns above {self._limit_hz:.3g} counts/s: dim the light")
        return notes
