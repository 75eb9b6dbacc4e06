"""Our solver against others on the same rows, with the same motion: time to the same PSNR, as ratios within one run.

``OPENBLAS_NUM_THREADS=1 python -m benchmarks.comparison [--region] [--repeats 3] [--tval3 FOLDER] [--write-mat FILE]``

Every other solver has the best of a ladder of weights (found with the truth at hand), and its clock stops at the first image
whose PSNR is 0.1 dB below the lower of both best ones. Building the rows is not timed, of either side.
"""

import argparse
import os
import shutil
import time
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import partial
from pathlib import Path
from statistics import median
from typing import TypeAlias, cast

import numpy as np
from skimage.restoration import denoise_tv_chambolle  # pyright: ignore[reportUnknownVariableType]  (it carries no types)

from benchmarks.dense import DenseSingles
from benchmarks.octave import SETTINGS, Written, run_octave
from benchmarks.scenes import FRAMES, SIZE, diagonal, recorded, scene
from instrument.choices import Extent
from instrument.measurement import Measurement
from instrument.numerics import (
    Operator,
    Weighted,
    largest_eigenvalue,
    psnr,
    total_variation,
    tv_augmented_lagrangian,
)
from instrument.plan import Plan
from instrument.reconstruction import Field, Problem, Region, ShiftedHadamard, walsh_rows
from instrument.tracking import as_trajectory
from protocols import Floats, Singles


def cut(image: Floats, region: Region) -> Floats:
    """Give the part of ``(size, size)`` inside a region."""
    return image[region.top : region.top + region.height, region.left : region.left + region.width]


Watch: TypeAlias = Callable[[Floats], object]
Solver: TypeAlias = Callable[[Operator, Singles, float, Watch], object]

_chambolle = cast("Callable[..., Singles]", denoise_tv_chambolle)

NEAR_DB = 0.1
MU = (2.0**4, 2.0**6, 2.0**8, 2.0**10)
STRENGTHS = (1.0, 2.0, 4.0)


@dataclass(frozen=True)
class Comparison:
    """Whitened rows of one run with its true motion."""

    rows: Operator
    written: Written
    truth: Floats
    """On the whole field."""
    area: Region

    @property
    def values(self) -> Singles:
        """``(rows,)``."""
        return self.written.values

    @classmethod
    def of(cls, *, region: Extent, seed: int) -> "Comparison":
        """Simulate the letter on motion II, noise of 0.1 on every pixel."""
        recording = recorded(Plan(frames=FRAMES, image_size=SIZE), scene("letter-B"), diagonal, sigma=0.1, seed=seed)
        truth = recording.truth
        assert truth is not None  # noqa: S101  (simulated)
        measurement = Measurement.of(recording)
        of_image = measurement.image_values(steady_object=region == "inside")
        motion = as_trajectory(truth.displacement_px, len(measurement), measurement.frame_time_s)
        problem = Problem.of(measurement, of_image, motion, region=region)
        area, pairs = problem.region, of_image.pairs
        middle = (problem.places.positive + problem.places.negative) / 2
        weighted, values = problem.hadamard()
        rows = Weighted(ShiftedHadamard.single(pairs, middle, Field(SIZE), area), weighted.weight)
        down = walsh_rows(Field(SIZE), pairs[:, 0], middle[:, 1], area.top, area.height)
        across = weighted.weight[:, None] * walsh_rows(Field(SIZE), pairs[:, 1], middle[:, 0], area.left, area.width)
        return cls(rows, Written(down, across, values, cut(truth.image, area)), truth.image, area)

    def dense(self) -> DenseSingles:
        """Give the same rows written out, in double precision."""
        down, across = self.written.down.astype(np.float64), self.written.across
        return DenseSingles((down[:, :, None] * across[:, None, :]).reshape(self.rows.shape), self.area.shape)

    def quality_db(self, image: Floats | Singles) -> float:
        """PSNR of an image of the region, on the whole field."""
        return psnr(self.area.paste(image.astype(np.float64), SIZE), self.truth)


@dataclass
class Course:
    """PSNR over the time of a solver; judging is not on its clock."""

    problem: Comparison
    points: list[tuple[float, float]] = field(default_factory=list[tuple[float, float]])
    paused_s: float = 0.0
    started_s: float = field(default_factory=time.perf_counter)

    def __call__(self, image: Floats) -> None:
        """Note an image."""
        now_s = time.perf_counter()
        self.points.append((now_s - self.started_s - self.paused_s, self.problem.quality_db(image)))
        self.paused_s += time.perf_counter() - now_s

    @property
    def best_db(self) -> float:
        """Best so far."""
        return max(quality for _, quality in self.points)

    def reached_s(self, wanted_db: float) -> float:
        """When a PSNR was first reached."""
        return next((at_s for at_s, quality in self.points if quality >= wanted_db), float("inf"))


def ours(operator: Operator, values: Singles, steps: tuple[int, int] | None = None) -> Singles:
    """Our solver as it is, or stopped: ``steps`` are reweightings and iterations for each solution."""
    if steps is None:
        return total_variation(operator, values).image
    return total_variation(operator, values, reweightings=steps[0], iterations=steps[1], tolerance=0).image


def fista(operator: Operator, values: Singles, strength: float, watch: Watch) -> None:
    """Beck and Teboulle (2009) with scikit-image's total-variation denoiser as its proximal step, x >= 0."""
    noise = np.random.default_rng(0).standard_normal(len(values)).astype(np.float32)
    curvature = 1.05 * largest_eigenvalue(operator)
    weight = strength * float(np.std(operator.rmatvec(noise))) / curvature
    image: Singles = np.zeros(operator.image_shapes[0], np.float32)
    ahead = image
    momentum = 1.0
    for _ in range(100):
        pull = operator.rmatvec(operator.matvec(ahead.ravel()) - values).reshape(image.shape)
        wanted = ahead - pull / np.float32(curvature)
        after: Singles = np.maximum(_chambolle(wanted, weight=weight, eps=1e-6, max_num_iter=20), 0)
        faster = (1 + float(np.sqrt(1 + 4 * momentum**2))) / 2
        ahead = (after + np.float32((momentum - 1) / faster) * (after - image)).astype(np.float32)
        image, momentum = after, faster
        watch(image.astype(np.float64))


def augmented(operator: Operator, values: Singles, mu: float, watch: Watch) -> None:
    """TVAL3's method in numpy, until it stops by itself."""
    tv_augmented_lagrangian(operator, values, mu=mu, watch=watch)


def tuned(problem: Comparison, solver: Solver, ladder: tuple[float, ...]) -> tuple[float, float]:
    """Best weight of a ladder, and its PSNR: found on the structured rows, as the images are the same."""

    def best_db(weight: float) -> float:
        course = Course(problem)
        solver(problem.rows, problem.values, weight, course)
        return course.best_db

    found = {weight: best_db(weight) for weight in ladder}
    best = max(found, key=found.__getitem__)
    return best, found[best]


def seconds(work: Callable[[], object], repeats: int) -> float:
    """Median time of one call."""

    def once() -> float:
        started_s = time.perf_counter()
        work()
        return time.perf_counter() - started_s

    return median(once() for _ in range(repeats))


def ours_to(problem: Comparison, wanted_db: float, repeats: int) -> float:
    """Time of our solver, stopped where it first reaches a PSNR: the least of plain and reweighted solutions."""
    ladder = [(freed, steps) for steps in range(10, 151, 10) for freed in (0, 1)]
    for steps in sorted(ladder, key=lambda pair: (1 + pair[0]) * pair[1]):
        if problem.quality_db(ours(problem.rows, problem.values, steps)) >= wanted_db:
            return seconds(partial(ours, problem.rows, problem.values, steps), 2 * repeats + 1)
    return float("inf")


def say(name: str, quality_db: float, whole_s: float, wanted_db: float, *, other_s: float, ours_s: float) -> None:
    """Print a line of the table."""
    print(
        f"{name:42s} {quality_db:8.2f} {whole_s:9.2f} {wanted_db:8.2f} {other_s:9.3f} {ours_s:9.3f} {other_s / ours_s:7.1f}",
        flush=True,
    )


def compare(
    problem: Comparison, name: str, solver: Solver, ladder: tuple[float, ...], *, best_db: float, repeats: int
) -> None:
    """Time one other solver on the dense matrix, and ours to the same PSNR."""
    weight, reached_db = tuned(problem, solver, ladder)
    wanted_db = min(best_db, reached_db) - NEAR_DB
    dense = problem.dense()
    whole_s: list[float] = []
    reached_s: list[float] = []
    for _ in range(repeats):
        course = Course(problem)
        solver(dense, problem.values, weight, course)
        whole_s.append(course.points[-1][0])
        reached_s.append(course.reached_s(wanted_db))
    ours_s = ours_to(problem, wanted_db, repeats)
    say(f"{name}, {weight:g}", reached_db, median(whole_s), wanted_db, other_s=median(reached_s), ours_s=ours_s)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument(
        "--region", action="store_true", help="solve for the pixels the object can occupy, all solvers alike"
    )
    parser.add_argument("--repeats", type=int, default=3, help="of which medians are taken")
    parser.add_argument("--seed", type=int, default=0, help="of the noise")
    parser.add_argument("--tval3", type=Path, help="folder of TVAL3, to run it under Octave")
    parser.add_argument("--write-mat", type=Path, help="file for rows, values, truth and settings")
    arguments = parser.parse_args()
    repeats: int = arguments.repeats
    problem = Comparison.of(region="inside" if arguments.region else "field", seed=arguments.seed)
    threads = os.environ.get("OPENBLAS_NUM_THREADS", "all")
    print(f"cores {os.cpu_count()}, load {os.getloadavg()[0]:.1f}, BLAS threads {threads}; ratios hold within this run")
    height, width = problem.area.shape
    print(
        f"{problem.rows.shape[0]} rows, image {height} x {width}; mu and strength in the names are the best of the ladder"
    )
    if arguments.write_mat is not None:
        problem.written.write(arguments.write_mat)
        print(f"wrote {arguments.write_mat}; settings for TVAL3: {SETTINGS}")
    heads = ("best dB", "whole s", "equal dB", "to it s", "ours s", "ratio")
    print(f"{'':42s} " + " ".join(f"{h:>{w}s}" for h, w in zip(heads, (8, 9, 8, 9, 9, 7), strict=True)))
    best_db = problem.quality_db(ours(problem.rows, problem.values))
    ours_s = seconds(lambda: ours(problem.rows, problem.values), 2 * repeats + 1)
    say("ours, structured rows", best_db, ours_s, best_db, other_s=ours_s, ours_s=ours_s)
    dense = problem.dense()
    dense_s = seconds(lambda: ours(dense, problem.values), repeats)
    say(
        "ours, dense matrix",
        problem.quality_db(ours(dense, problem.values)),
        dense_s,
        best_db,
        other_s=dense_s,
        ours_s=ours_s,
    )
    compare(problem, "FISTA + scikit-image TV, dense; strength", fista, STRENGTHS, best_db=best_db, repeats=repeats)
    compare(problem, "tv-al (TVAL3 in numpy), dense; mu", augmented, MU, best_db=best_db, repeats=repeats)
    against_octave(problem, arguments.tval3, best_db, repeats)


def against_octave(problem: Comparison, folder: Path | None, best_db: float, repeats: int) -> None:
    """TVAL3 itself, where the user has it."""
    octave = shutil.which("octave-cli") or shutil.which("octave")
    if folder is None or octave is None:
        missing = "Octave is not on this machine" if folder is not None else "no --tval3 FOLDER given"
        print(f"TVAL3: left out, {missing}. Get it from its authors, install Octave, and pass --tval3 FOLDER;")
        print("or pass --write-mat FILE and run TVAL3 on it in MATLAB, by benchmarks/README.md.")
        return
    runs = {mu: run_octave(octave, folder, problem.written, mu=mu) for mu in MU}
    best = max(runs, key=lambda mu: problem.quality_db(runs[mu].image))
    again = [run_octave(octave, folder, problem.written, mu=best).took_s for _ in range(repeats - 1)]
    reached_db, took_s = problem.quality_db(runs[best].image), median([runs[best].took_s, *again])
    wanted_db = min(best_db, reached_db)
    ours_s = ours_to(problem, wanted_db, repeats)
    say(f"TVAL3 under Octave; mu {best:g}", reached_db, took_s, wanted_db, other_s=took_s, ours_s=ours_s)


if __name__ == "__main__":
    main()
