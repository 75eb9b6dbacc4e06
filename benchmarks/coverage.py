"""How often stated intervals of the path hold the truth, and whether the misfit is 1: ``python -m benchmarks.coverage``.

``[--places 8] [--draws 3] [--only TITLE]``, from the repository's root. The errors of one run hang together, so that a handful of
runs says little of an interval. Here each bench is simulated once at each place, without noise, and noise is drawn several times
for it, other noise for each line: on each lit pixel, as ``pixel`` noise has it, or photons. 128 x 128 pixels, up to 1,666 frames.
"covered" is the share of 95 % intervals that hold the truth, where half of the object is inside the field at least; "err/sig" the
rms of error over stated sigma, along x and y; "at a place" the part of the rms error that every draw at a place has in common, in
px.
"""

import argparse
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final
from zlib import crc32

import numpy as np

from benchmarks.effects import EFFECTS, Effect, at, straight
from benchmarks.scenes import SIZE, diagonal
from instrument import Recording, analyse
from instrument.analysis.leaving import share_inside
from instrument.schemes import image_rows_of, scheme_of
from protocols import Floats, KinopixError

_SIGMA: Final = 0.1

_OTHERS: Final = (
    Effect("diagonal", path=diagonal),
    Effect("at rest", path=lambda time_s: np.zeros((len(time_s), 2))),
    Effect("98 % flicker", {"led_flicker": 0.98}, path=straight(54)),
    Effect("fades to 10 %", {"led_drift_per_s": -1.8}, path=straight(54)),
)
_BENCHES: Final[Mapping[str, Effect]] = {effect.title: effect for effect in (*EFFECTS, *_OTHERS)}


@dataclass(frozen=True)
class Line:
    """One line of the table."""

    bench: str
    """Bench, by its title in ``benchmarks.effects`` or here."""

    counts: float = 0.0
    """Photons of an all-on pattern; 0 takes noise on every pixel."""

    frames: int | None = None
    """Frames of the run that are used, from the first on."""

    @property
    def title(self) -> str:
        """What it is called."""
        light = f", {self.counts:g} counts" if self.counts else ""
        return self.bench + light + (f", first {self.frames}" if self.frames else "")

    def runs(self, place: int, draws: int) -> Iterator[tuple[Recording, Floats]]:
        """Simulate the bench once, and draw noise for it."""
        with TemporaryDirectory() as folder:
            still, fine, _ = replace(_BENCHES[self.bench], noise=None).run(place, Path(folder))
        image = at(fine, SIZE)
        lit = lit_px(still)
        for draw in range(draws):
            rng = np.random.default_rng([99, place, draw, crc32(self.title.encode())])
            if self.counts:
                expected = np.maximum(still.values, 0) * self.counts / image.sum()
                values: Floats = np.asarray(rng.poisson(expected), np.float64)
            else:
                values = still.values + _SIGMA * np.sqrt(lit) * rng.standard_normal(still.values.shape)
            noisy = replace(still, values=values, photon_counts=self.counts > 0)
            yield (noisy.first(self.frames) if self.frames else noisy), image

    def found(self, places: int, draws: int) -> "Found":
        """Analyse all runs."""
        found = Found()
        for place in range(places):
            errors: list[Floats] = []
            for recording, image in self.runs(place, draws):
                try:
                    errors.append(found.add(recording, image))
                except KinopixError as error:
                    found.refused.append(str(error))
            if len(errors) > 1:
                every: Floats = np.stack(errors)
                common: Floats = every.mean(axis=0) ** 2 - every.var(axis=0, ddof=1) / len(errors)
                found.common.append(float(common.mean()))
        return found


@dataclass
class Found:
    """What came out at one line."""

    covered: list[float] = field(default_factory=list[float])
    ratio: list[Floats] = field(default_factory=list[Floats])
    error: list[float] = field(default_factory=list[float])
    misfit: list[float] = field(default_factory=list[float])
    common: list[float] = field(default_factory=list[float])
    refused: list[str] = field(default_factory=list[str])

    def add(self, recording: Recording, image: Floats) -> Floats:
        """Analyse one run, and give the errors of its path, ``(frames, 2)``, 0 where nothing is stated."""
        found = analyse(recording)
        assert recording.truth is not None  # noqa: S101  (a simulated run has one)
        assert found.trajectory is not None  # noqa: S101
        truth_px = recording.truth.displacement_px
        sigma_px = found.trajectory.sigma_px
        stated = share_inside(image, truth_px)[:, None] >= 0.5
        stated = stated & np.isfinite(sigma_px) & (sigma_px > 0)
        error_px = np.where(stated, found.trajectory.displacement_px - truth_px, 0.0)
        ratio = error_px / np.where(stated, sigma_px, 1.0)
        count = np.maximum(stated.sum(axis=0), 1)
        self.covered.append(float(np.mean(np.abs(ratio[stated]) < 1.96)))
        self.ratio.append(np.asarray((ratio**2).sum(axis=0) / count, np.float64))
        self.error.append(float(np.mean(error_px[stated] ** 2)))
        self.misfit.append(found.figures.misfit or float("nan"))
        return np.asarray(error_px, np.float64)

    def row(self) -> str:
        """Give its figures as a row of the table."""
        if not self.covered:
            return f"refused: {self.refused[0]}" if self.refused else "-"
        x, y = np.sqrt(np.mean(self.ratio, axis=0)).tolist()
        common = np.sqrt(max(float(np.mean(self.common)), 0.0)) if self.common else float("nan")
        refused = f" | {len(self.refused)} refused" if self.refused else ""
        return (
            f"{len(self.covered)} | {np.mean(self.covered):.3f} | {x:.2f}, {y:.2f} | {np.sqrt(np.mean(self.error)):.4f} | "
            f"{common:.4f} | {np.mean(self.misfit):.3f} +- {np.std(self.misfit):.3f}{refused}"
        )


def lit_px(recording: Recording) -> Floats:
    """``(frames, patterns_per_frame)``: lit pixels of each pattern, which make the variance of ``pixel`` noise."""
    scheme = scheme_of(recording.plan)
    rows, size = image_rows_of(scheme), recording.plan.image_size
    frames, columns = len(recording), len(scheme.columns)
    lit = np.full((frames, columns), size * size / 2)
    fixed = [column for column in range(columns) if column not in {rows.positive, rows.negative}]
    lit[:, fixed] = scheme.fixed_patterns.reshape(len(fixed), -1).mean(axis=1) * size * size
    all_on = (rows.pairs[np.arange(frames) % len(rows.pairs)] == 0).all(axis=1)
    lit[all_on, rows.positive], lit[all_on, rows.negative] = size * size, 0
    return lit


LINES: Final = (
    Line("ideal"),
    Line("diagonal"),
    Line("at rest"),
    Line("ideal, plane"),
    Line("ideal, bars"),
    Line("ideal, 20 px"),
    Line("ideal, 12 px"),
    Line("ideal", frames=333),
    Line("ideal", frames=100),
    Line("ideal", frames=40),
    Line("ideal", frames=10),
    Line("ideal", 50.0),
    Line("ideal", 500.0),
    Line("ideal", 8000.0),
    Line("ideal", 3.0),
    Line("leak 0.125"),
    Line("edge loss 0.1"),
    Line("background, R 1.6"),
    Line("background, 12 px"),
    Line("leaves, 110 px"),
    Line("light falls by 35 %"),
    Line("98 % flicker"),
    Line("98 % flicker", 500.0),
    Line("fades to 10 %", 500.0),
)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--places", type=int, default=8)
    parser.add_argument("--draws", type=int, default=3, help="draws of the noise at each place")
    parser.add_argument("--only", default="", help="lines whose title contains this")
    arguments = parser.parse_args()
    print("| line | runs | covered | err/sig x, y | rms error, px | at a place, px | misfit |")
    print("|---|---|---|---|---|---|---|")
    for line in LINES:
        if arguments.only in line.title:
            print(f"| {line.title} | {line.found(arguments.places, arguments.draws).row()} |", flush=True)


if __name__ == "__main__":
    main()
