"""A study so small that tests can sweep over it: what other processes import by name."""

import os
from pathlib import Path

import numpy as np

from instrument.studies import Axis, Case, Claim, Outcome, Point, Simulated, Study, Summary

MARKS = "KINOPIX_TEST_MARKS"
"""Environment variable: folder in which each computed point leaves a file."""


def compute(settings: Simulated, seed: int) -> dict[str, Outcome]:
    """Sum products whose result hangs on the order of summing."""
    if MARKS in os.environ:
        mark = Path(os.environ[MARKS]) / f"{settings.velocity_mm_s:g}-{seed}-{os.getpid()}"
        mark.touch()
    rng = np.random.default_rng(seed)
    matrix = rng.standard_normal((300, 300))
    image = matrix @ matrix.T * settings.velocity_mm_s
    figures = {"mse_px2": float(abs(image.sum())), "psnr_db": settings.velocity_mm_s + seed}
    return {"one": Outcome(figures, image[:4, :4])}


def refuse(settings: Simulated, seed: int) -> dict[str, Outcome]:
    """Fail for seed 1."""
    if seed == 1:
        raise ValueError("seed 1 is not liked")
    return compute(settings, seed)


def hang(settings: Simulated, seed: int) -> dict[str, Outcome]:
    """Go on for longer than any test for seeds from 2 on."""
    outcome = compute(settings, seed)
    while seed >= 2:
        np.random.default_rng(0).standard_normal(100_000).sum()
    return outcome


def points(seeds: int, function: str = "compute") -> list[Point]:
    """Points of one case."""
    return [Point(f"tiny, seed {seed}", "tiny", globals()[function], Simulated(), seed) for seed in range(seeds)]


def _claims(summary: Summary) -> list[Claim]:
    return [Claim(f"{summary.mean('a, 1', 'one', 'psnr_db'):g}", holds=True), Claim("never", holds=False)]


STUDY = Study(
    name="noise",
    title="Tiny",
    about="Two cases.",
    cases=(
        Case("a, 1", Simulated(velocity_mm_s=1.0), "a", 1.0),
        Case("a, 2", Simulated(velocity_mm_s=2.0), "a", 2.0),
    ),
    processings=("one",),
    compute=compute,
    claims=_claims,
    differences="None.",
    axis=Axis("speed"),
    paper={("a, 1", "psnr_db"): 1.5},
)
"""A study of two cases."""


def interrupted(settings: Simulated, seed: int) -> dict[str, Outcome]:
    """Be interrupted at seed 1."""
    if seed == 1:
        raise KeyboardInterrupt
    return compute(settings, seed)
