"""Whether slips are told, placed and mended, and whether any is seen where there is none: ``python -m benchmarks.doubt``.

``[--runs 50] [--counts 50 280] [--analysed | --clean]``. Runs are those of ``benchmarks.drawn_runs``. Each is looked at as it
is, with all values one pattern late and early, and with one value lost at a place drawn at random. "false" are runs without a
fault in which a slip was found or a frame masked for one; "placed" are those in which the lost value was told to 3 patterns;
"kept" is the median share of frames that stay valid; "wrong" are frames of all runs that are valid and hold a value of another
pattern.

``--analysed`` looks at the analysis instead, which has path and image beside the counts. "false" are runs without a fault in
which a slip was told; "placed" are those in which the lost value was told to 3 patterns, "held" those in which it was in the
range that was told; "in reach" are those in which the likeliest place is within 3 patterns where the values are known
without noise, which no method can do better than: each pattern differs from the one before by half of what photons scatter.
"MSE" and "PSNR" are ratio and difference of the figures to those of the run without the fault, median over runs, and "of
all" the ratio of the mean squared errors over all runs but those with bars; "s" is the mean time of both analyses, "most s"
the longest. A run that is refused, with the fault or without, counts as not told.

``--clean`` analyses runs without a fault alone: "slips" and "contradictions" are false alarms.
"""

import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Final

import numpy as np

from benchmarks.drawn_runs import against_truth, options, recorded, seeds, with_its_light
from instrument import Recording, analyse
from instrument.measurement import Slips, cheapest_place, in_step_again, slips_of_counts
from instrument.schemes import scheme_of
from protocols import Floats, InputError

COUNTS: Final = (50, 100, 280, 1000, 4000)


def without(values: Floats, lost: int) -> Floats:
    """Lose a value; the last one is there twice."""
    return np.append(np.delete(values.ravel(), lost), values[-1, -1]).reshape(values.shape)


def in_reach(values: Floats, light: Floats, lost: int) -> bool:
    """Whether the likeliest place of the lost value is within 3 patterns of it, the light being known."""
    expected = np.maximum(light.ravel() * (values.sum() / light.sum()), 1e-9)
    came = without(values, lost).ravel()
    after = np.append(expected[1:], expected[-1])
    before, behind = (2 * (of - came * np.log(of)) for of in (expected, after))
    return abs(cheapest_place(before, behind, 1.0)[0] - lost) <= 3


def slips_in(recording: Recording, values: Floats) -> Slips:
    """Look for slips as the screening does."""
    return slips_of_counts(values, recording.frame_valid, scheme_of(recording.plan), photon_counts=True)


@dataclass
class Line:
    """What was found at one light, on one kind of bench."""

    false: int = 0
    late: int = 0
    early: int = 0
    placed: int = 0
    kept: list[float] = field(default_factory=list[float])
    wrong: int = 0

    def add(self, rng: np.random.Generator, counts: float, *, ideal: bool) -> None:
        """Draw a run and look at it."""
        recording = recorded(rng, counts, ideal=ideal)
        values = recording.values
        found = slips_in(recording, values)
        self.false += found.any or not found.sure.all()
        for by in (1, -1):
            shifted = np.roll(values.ravel(), by).reshape(values.shape)
            found = slips_in(recording, shifted)
            right = [part.shift for part in found.segments] == [by]
            self.late += right and by > 0
            self.early += right and by < 0
            self._mended(found, shifted, values)
        lost = int(rng.integers(120, values.size - 120))
        short = without(values, lost)
        found = slips_in(recording, short)
        if [part.shift for part in found.segments] == [0, -1]:
            self.placed += abs(found.segments[1].first_pattern - lost) <= 3
        self._mended(found, short, values)

    def _mended(self, found: Slips, values: Floats, truth: Floats) -> None:
        """Count the frames that are kept, and those of them that are wrong."""
        mended = in_step_again(values, found) if found.any else np.where(found.sure[:, None], values, np.nan)
        valid = np.isfinite(mended).all(axis=1)
        self.wrong += int(np.count_nonzero((mended != truth).any(axis=1) & valid))
        if found.any:
            self.kept.append(float(valid.mean()))

    def row(self) -> str:
        """Give a row of the table."""
        kept = float(np.median(self.kept)) if self.kept else float("nan")
        return f"{self.false} | {self.late} | {self.early} | {self.placed} | {kept:.3f} | {self.wrong}"


@dataclass
class Analysed:
    """What analyses found at one light, on one kind of bench."""

    false: int = 0
    told: int = 0
    placed: int = 0
    held: int = 0
    reach: int = 0
    ratio: list[float] = field(default_factory=list[float])
    more_db: list[float] = field(default_factory=list[float])
    squares: list[tuple[float, float]] = field(default_factory=list[tuple[float, float]])
    took_s: list[float] = field(default_factory=list[float])

    def add(self, rng: np.random.Generator, counts: float, *, ideal: bool) -> None:
        """Draw a run and look at it."""
        recording, light, name = with_its_light(rng, counts, ideal=ideal, lit=True)
        lost = int(rng.integers(120, recording.values.size - 120))
        assert light is not None  # noqa: S101  (asked for)
        self.reach += in_reach(recording.values, light, lost)
        started_s = time.perf_counter()
        try:
            clean = analyse(recording).figures
            self.false += any("values come" in text for text in clean.found)
            found = analyse(replace(recording, values=without(recording.values, lost)))
        except InputError:
            return
        finally:
            self.took_s.append(time.perf_counter() - started_s)
        (mse, psnr_db), (of_clean, clean_psnr_db) = against_truth(found.figures), against_truth(clean)
        self.ratio.append(mse / of_clean)
        self.more_db.append(psnr_db - clean_psnr_db)
        if name != "bars":
            self.squares.append((mse, of_clean))
        slips = found.measurement.slips
        if slips is None or [part.shift for part in slips.segments] != [0, -1]:
            return
        place = slips.segments[1].first_pattern
        first, last = slips.segments[1].within or (place - 3, place + 3)
        self.told += 1
        self.placed += abs(place - lost) <= 3
        self.held += first <= lost <= last

    def row(self) -> str:
        """Give a row of the table."""
        mse, of_clean = np.array(self.squares).reshape(-1, 2).sum(axis=0)
        of_all = mse / of_clean if of_clean > 0 else np.nan
        figures = f"{np.median(self.ratio):.3f} | {of_all:.3f} | {np.median(self.more_db):+.2f}"
        took = f"{np.mean(self.took_s):.1f} | {max(self.took_s):.1f}"
        return f"{self.false} | {self.told} | {self.placed} | {self.reach} | {self.held} | {figures} | {took}"


@dataclass
class Clean:
    """What analyses of runs without a fault told at one light, on one kind of bench."""

    slips: int = 0
    contradictions: int = 0
    refused: int = 0

    def add(self, rng: np.random.Generator, counts: float, *, ideal: bool) -> None:
        """Draw a run and look at it."""
        try:
            found = analyse(recorded(rng, counts, ideal=ideal)).measurement.findings
        except InputError:
            self.refused += 1
            return
        self.slips += any(finding.kind == "shifted patterns" for finding in found)
        self.contradictions += any(finding.kind == "contradiction" for finding in found)

    def row(self) -> str:
        """Give a row of the table."""
        return f"{self.slips} | {self.contradictions} | {self.refused}"


def print_table(
    heads: str, line_of: Callable[[], Line | Analysed | Clean], runs: range, counts: Sequence[float]
) -> None:
    """Print one line for each light, of ideal benches and of others."""
    columns = f"| bench | counts | runs | {heads} |"
    print(columns)
    print("|" + "---|" * (columns.count("|") - 1))
    for ideal in (True, False):
        for light_counts in counts:
            line = line_of()
            for seed in runs:
                line.add(np.random.default_rng([12, seed]), light_counts, ideal=ideal)
            name = "ideal" if ideal else "with flaws"
            print(f"| {name} | {light_counts:g} | {len(runs)} | {line.row()} |", flush=True)


def main() -> None:
    """Print what the counts tell by themselves, or what an analysis does."""
    parser = options(__doc__)
    parser.add_argument("--counts", type=float, nargs="+", default=COUNTS, help="counts of an all-on pattern")
    parser.add_argument("--analysed", action="store_true", help="look at what an analysis tells")
    parser.add_argument(
        "--clean", action="store_true", help="look at what an analysis tells of runs without a fault alone"
    )
    arguments = parser.parse_args()
    if arguments.clean:
        heads, line_of = "slips | contradictions | refused", Clean
    elif arguments.analysed:
        heads, line_of = "false | told | placed | in reach | held | MSE | of all | PSNR, dB | s | most s", Analysed
    else:
        heads, line_of = "false | late told | early told | lost one placed | kept | wrong frames", Line
    print_table(heads, line_of, seeds(arguments), arguments.counts)


if __name__ == "__main__":
    main()
