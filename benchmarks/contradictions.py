"""Whether runs whose patterns are not where they were planned are named by their cause, and mended.

``python -m benchmarks.contradictions [--runs 50] [--counts 50] [--flaws]``, from the repository's root. Runs are those of
``benchmarks.drawn_runs``. "named" are runs with the right cause among what the analysis tells, "mended" those
whose path is within twice the squared error of the run as planned (or 0.05 px^2) and whose image is within 1 dB of it; "s" is
the mean time of an analysis. A lost frame is drawn from the first two thirds of the run; "placed" are those that the range told
holds. Axes are exchanged in runs 10 degrees and more off the field's diagonal, along which both say the same, and phases along x
reversed in runs of a pixel and more along x, without which that changes nothing. Mirrored and turned images are not here: that
takes a stage and its calibration, and is exact (see the tests).
"""

import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from benchmarks.drawn_runs import FRAMES, against_truth, options, recorded, seeds
from instrument import Analysis, Recording, analyse
from protocols import Floats, InputError

Change = Callable[[Floats, int], Floats]


def _columns(*order: int) -> Change:
    return lambda values, _lost: values[:, list(order)]


def _rolled(by: int) -> Change:
    return lambda values, _lost: np.roll(values.ravel(), by).reshape(values.shape)


def _without(values: Floats, lost: int) -> Floats:
    return np.concatenate([np.delete(values, lost, axis=0), values[-1:]])


@dataclass(frozen=True)
class Kind:
    """One way in which patterns are not where they were planned."""

    change: Change
    """Gives the values as they would come, from those as planned and the frame that is lost."""

    words: tuple[str, ...]
    """Words of which one must be told; none for nothing at all."""

    off_diagonal_deg: float = 0.0
    """Angle to the field's diagonal from which on a path shows it."""

    along_x_px: float = 0.0
    """Travel along x from which on a path shows it."""

    def shows(self, displacement_px: Floats) -> bool:
        """Whether a run along that path, ``(frames, 2)``, shows it."""
        x, y = np.abs(displacement_px[-1])
        return bool(abs(np.degrees(np.arctan2(y, x)) - 45) >= self.off_diagonal_deg and x >= self.along_x_px)


KINDS: Final[Mapping[str, Kind]] = {
    "as planned": Kind(lambda values, _lost: values, ()),
    "axes exchanged": Kind(_columns(2, 3, 0, 1, 4, 5), ("along x and y are exchanged",), off_diagonal_deg=10.0),
    "x phases reversed": Kind(_columns(1, 0, 2, 3, 4, 5), ("in the place of x come in the reverse",), along_x_px=1.0),
    "H- first": Kind(_columns(0, 1, 2, 3, 5, 4), ("H- comes first", "the fringes are inverted")),
    "one pattern late": Kind(_rolled(1), ("late",)),
    "one pattern early": Kind(_rolled(-1), ("early",)),
    "a frame lost": Kind(_without, ("a whole frame was lost",)),
}
"""On benches with inverted mirrors, exchanged H+ and H- are inverted fringes."""


@dataclass
class Line:
    """What came of one kind."""

    runs: int = 0
    named: int = 0
    mended: int = 0
    placed: int = 0
    took_s: float = 0.0

    def add(self, kind: Kind, run: Recording, lost: int, planned: Analysis) -> None:
        """Analyse one run."""
        assert run.truth is not None  # noqa: S101  (a simulated run has one)
        if not kind.shows(run.truth.displacement_px):
            return
        self.runs += 1
        started_s = time.perf_counter()
        try:
            found = analyse(replace(run, values=kind.change(run.values, lost))).figures
        except InputError:
            return
        finally:
            self.took_s += time.perf_counter() - started_s
        own = [text for text in found.found if text not in planned.figures.found or not kind.words]
        told = [text for text in own if any(word in text for word in kind.words)]
        self.named += (
            bool(told) if kind.words else not [text for text in own if "inverts" not in text and "wild" not in text]
        )
        (mse, psnr_db), (mse_before, psnr_db_before) = against_truth(found), against_truth(planned.figures)
        self.mended += mse < max(2 * mse_before, 0.05) and psnr_db > psnr_db_before - 1
        numbers = [int(word) for text in told for word in text.split() if word.isdigit()]
        self.placed += bool(numbers) and min(numbers) <= lost + 1 and lost - 1 <= max(numbers)


def main() -> None:
    """Print the table."""
    parser = options(__doc__)
    parser.add_argument("--counts", type=float, default=50.0, help="counts of an all-on pattern")
    parser.add_argument("--flaws", action="store_true", help="on benches with flaws drawn at random")
    arguments = parser.parse_args()
    lines = {name: Line() for name in KINDS}
    for seed in seeds(arguments):
        rng = np.random.default_rng([13, seed])
        run = recorded(rng, arguments.counts, ideal=not arguments.flaws)
        lost = int(rng.integers(3, 2 * FRAMES // 3))
        planned = analyse(run)
        for name, kind in KINDS.items():
            lines[name].add(kind, run, lost, planned)
        print(seed, lost, {name: (line.runs, line.named, line.mended) for name, line in lines.items()}, flush=True)
    print("| kind | runs | named | mended | placed | s |")
    print("|---|---|---|---|---|---|")
    for name, line in lines.items():
        placed = line.placed if "lost" in name else "-"
        took_s = line.took_s / max(line.runs, 1)
        print(f"| {name} | {line.runs} | {line.named} | {line.mended} | {placed} | {took_s:.2f} |")


if __name__ == "__main__":
    main()
