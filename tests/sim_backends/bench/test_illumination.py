"""Uneven light in the field."""

from pathlib import Path

import numpy as np
import pytest

from sim_backends.bench.illumination import illumination
from tests.sim_backends.projector import SIZE, all_on, bench_with, dot, pixel, save, show, values


def test_light_falls_with_the_square_of_the_distance_to_the_corner() -> None:
    """Two by two: centres at a quarter, halfway to the corners, where (1/2)^2 of the falloff is missing."""
    assert illumination(2, 0.4) == pytest.approx(np.full((2, 2), 0.9))
    fine = illumination(1000, 0.4)
    assert (fine[0, 0], fine[500, 500]) == (pytest.approx(0.6, abs=1e-3), pytest.approx(1.0, abs=1e-5))
    assert fine[500, 0] == pytest.approx(0.8, abs=1e-3)  # the middle of a side is nearer by the root of 2


def _profile(row: float, column: float, falloff: float) -> float:
    """By hand, on 16 pixels: (r / corner)^2 = (dx^2 + dy^2) / (8^2 + 8^2)."""
    return 1 - falloff * ((row + 0.5 - 8) ** 2 + (column + 0.5 - 8) ** 2) / 128


def test_the_profile_stands_still_while_the_object_moves_through_it(tmp_path: Path) -> None:
    (tmp_path / "path.csv").write_text("t_s,x_px,y_px\n0,10,0\n4e-5,10,0\n6e-5,3,0\n1e-4,3,0\n")
    scene = {"object": save(tmp_path, dot(1, 2)), "trajectory": "path.csv", "illumination_falloff": 0.35}
    bench = bench_with(tmp_path, **scene)
    show(bench, [all_on(), all_on()])
    assert bench.counts(0, 2).tolist() == pytest.approx([_profile(1, 12, 0.35), _profile(1, 5, 0.35)])
    assert bench.truth(np.zeros(1)).image[1, 12] == 1.0  # what is there, not what is lit


def test_single_mirrors_see_it_finer_and_the_background_lies_in_it_too(tmp_path: Path) -> None:
    fine = np.zeros((2 * SIZE, 2 * SIZE), np.uint8)
    fine[8, 10] = 1  # the mirror from column 5 to 5.5 and row 4 to 4.5
    still = pixel(1, 1).repeat(2, 0).repeat(2, 1)
    save(tmp_path, dot(1, 1), "still.npy")
    bench = bench_with(
        tmp_path,
        object=save(tmp_path, dot(4, 5)),
        illumination_falloff=0.35,
        background="still.npy",
        background_level=0.5,
    )
    mirror = _profile(4 - 0.25, 5 - 0.25, 0.35) / 4
    assert values(bench, [fine, still]) == pytest.approx([mirror, 0.5 * _profile(1, 1, 0.35)])


def test_peak_counts_are_those_of_an_all_lit_picture_in_the_light_that_there_is(tmp_path: Path) -> None:
    noise = {"kind": "poisson", "peak_counts": 1e6, "seed": 1}
    bench = bench_with(tmp_path, object=save(tmp_path, dot(0, 0)), illumination_falloff=0.9, noise=noise)
    assert values(bench, [all_on()])[0] == pytest.approx(1e6, abs=5e3)
