"""A plan on the simulated bench in one call: against the oracle, from a script's arrays, and with nothing left behind."""

import tempfile
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import kinopix
from instrument.config import ConfigError
from instrument.plan import MotionPlan, Plan
from instrument.schemes import scheme_of
from instrument.session import simulate
from protocols import Floats, InputError, PlanError, TimingFault
from tests.support import simulation as oracle
from tests.support.plans import plan_of

PLAN = Plan(frames=40, image_size=32, superpixel=4)
IMAGE = np.random.default_rng(8).random((32, 32))
RUN_S = PLAN.run_time_s


def curve(time_s: Floats) -> Floats:
    """A smooth path that takes a part of the image out of the field."""
    return np.stack([9.3 * np.sin(200 * time_s), 17 * time_s / RUN_S - 3], axis=1)


def jumps(time_s: Floats) -> Floats:
    """A new place with every pattern."""
    step = np.floor(time_s / 50e-6 + 1e-6)
    return np.stack([step % 7 - 3, 1.37 * (step % 5) - 2], axis=1)


def test_it_is_a_public_name() -> None:
    assert kinopix.simulate is simulate


@pytest.mark.parametrize("path", [curve, jumps])
@pytest.mark.parametrize(
    "plan",
    [
        PLAN,
        plan_of("moment-hadamard", 40, image_size=32, upsampling=1),
        plan_of("hadamard", 40, image_size=32),
        plan_of("fourier-3step", 40, image_size=32),
    ],
    ids=lambda plan: plan.scheme.name,
)
def test_values_and_truth_are_those_of_the_formulas(plan: Plan, path: oracle.Path2D) -> None:
    """Places are written with nine decimals, so that a value, a slope of less than 32 a pixel, is off by less than 1e-7."""
    ours, formulas = simulate(plan, image=IMAGE, path=path), oracle.simulate(plan, IMAGE, path)
    assert ours.values.shape == (40, plan.patterns_per_frame)
    np.testing.assert_allclose(ours.values, formulas.values, atol=1e-7)
    assert ours.truth is not None
    assert formulas.truth is not None
    np.testing.assert_allclose(ours.truth.displacement_px, formulas.truth.displacement_px, atol=2e-9)
    np.testing.assert_allclose(ours.truth.image, formulas.truth.image, atol=1e-8)


@pytest.mark.parametrize("path", [curve, jumps])
def test_patterns_finer_than_the_image_see_where_in_a_pixel_its_light_is(path: oracle.Path2D) -> None:
    """The oracle averages such patterns over each pixel first; here the object itself is drawn on the finer samples."""
    plan = plan_of("moment-hadamard", 40, image_size=32, upsampling=2)
    sequence = scheme_of(plan).sequence()
    fine: Floats = np.kron(IMAGE, np.full((2, 2), 0.25)).astype(np.float64)
    places: list[tuple[float, float]] = path((np.arange(160, dtype=np.float64) + 0.5) * plan.picture_time_s).tolist()
    expected = [
        float((sequence.sample_plane(int(k)) * oracle.shifted(fine, 2 * dx, 2 * dy)).sum())
        for k, (dx, dy) in zip(sequence.play_order[:-1], places, strict=True)
    ]
    np.testing.assert_allclose(simulate(plan, image=IMAGE, path=path).values.ravel(), expected, atol=1e-7)


@pytest.mark.parametrize("dark", [0, 5])
def test_an_image_lands_on_the_grid_pixel_for_pixel(dark: int) -> None:
    """Dark borders, which the bench leaves out of its sums, move nothing."""
    image = IMAGE.copy()
    image[:dark], image[:, 32 - 2 * dark :] = 0, 0
    recording = simulate(PLAN, image=image)
    assert recording.truth is not None
    np.testing.assert_allclose(recording.truth.image, image, atol=1e-12)
    np.testing.assert_array_equal(recording.truth.displacement_px, 0.0)


def test_photons_are_counted_at_the_mean_that_peak_counts_says() -> None:
    scene = {"noise": {"kind": "poisson", "peak_counts": 500.0, "seed": 3}}
    image = np.pad(IMAGE[:16, :16], 8)
    ours = simulate(PLAN, scene, image=image, path=lambda t: 60 * t[:, None] * np.ones(2))
    exact = oracle.simulate(PLAN, image, lambda t: 60 * t[:, None] * np.ones(2)).values * 500 / image.sum()
    assert ours.photon_counts
    assert ours.values.sum() == pytest.approx(exact.sum(), abs=4 * np.sqrt(exact.sum()))
    assert np.mean((ours.values - exact) ** 2 / np.maximum(exact, 1)) == pytest.approx(1.0, abs=0.35)


def test_noise_on_every_pixel_is_as_strong_as_the_scene_says() -> None:
    """The variance of 240 values is known to 9 %."""
    exact = simulate(PLAN, image=IMAGE).values
    noisy = simulate(PLAN, {"noise": {"kind": "pixel", "sigma": 0.1, "seed": 1}}, image=IMAGE).values
    lit = 32 * 32 / 2  # of each pattern, but for the first Hadamard pair
    assert np.std((noisy - exact)[1:]) == pytest.approx(0.1 * np.sqrt(lit), rel=0.2)


def test_a_seed_repeats_a_run_to_the_bit() -> None:
    scene = {"object": "letter-B", "noise": {"kind": "pixel", "sigma": 0.1, "seed": 4}}
    plan = PLAN.model_copy(update={"motion": MotionPlan(velocity_mm_s=25.0)})
    np.testing.assert_array_equal(simulate(plan, scene).values, simulate(plan, scene).values)


def test_without_a_path_the_stage_carries_the_object() -> None:
    """25 mm/s at 7.2 * 32 / 128 = 1.8 px/mm along the diagonal: 45 px/s / sqrt(2) along each axis."""
    recording = simulate(PLAN.model_copy(update={"motion": MotionPlan(velocity_mm_s=25.0)}), {"object": "disc"})
    assert recording.truth is not None
    middle_s = np.arange(40) * PLAN.frame_time_s
    expected = (45 / np.sqrt(2) * middle_s)[:, None] * np.ones(2)
    np.testing.assert_allclose(recording.truth.displacement_px, expected, atol=1e-4)


def test_a_path_takes_the_place_of_the_stages_motion() -> None:
    moving = PLAN.model_copy(update={"motion": MotionPlan(velocity_mm_s=25.0)})
    np.testing.assert_array_equal(
        simulate(moving, image=IMAGE, path=curve).values, simulate(PLAN, image=IMAGE, path=curve).values
    )


def test_numbers_of_numpy_and_tuples_are_taken_as_toml_has_them() -> None:
    scene = {
        "object": Path("letter-B"),
        "start_px": (np.float64(9), 9.5),
        "noise": {"kind": "pixel", "seed": np.int64(2)},
    }
    plain = {"object": "letter-B", "start_px": [9.0, 9.5], "noise": {"kind": "pixel", "seed": 2}}
    np.testing.assert_array_equal(simulate(PLAN, scene).values, simulate(PLAN, plain).values)


def test_nothing_is_left_on_the_disk(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(tempfile, "tempdir", str(tmp_path))
    monkeypatch.chdir(tmp_path)
    assert simulate(PLAN, image=IMAGE, path=curve).path is None
    with pytest.raises(TimingFault):
        simulate(PLAN, {"faults": [{"kind": "stall", "picture": 100}]}, image=IMAGE)
    assert list(tmp_path.iterdir()) == []


def wrong_path(time_s: Floats) -> Floats:
    return np.zeros(len(time_s))


def broken_path(time_s: Floats) -> Floats:
    return np.stack([time_s, 1 / (time_s - time_s[3])], axis=1)


@pytest.mark.parametrize(
    ("scene", "arguments", "error", "says"),
    [
        ({"objekt": "disc"}, {}, ConfigError, r"scene\.objekt: .*did you mean object"),
        ({"noise": {"kind": "pixel", "sigma": "0.1"}}, {}, ConfigError, r'scene\.noise\.sigma: saw "0\.1"'),
        ({"kind": "holodeck"}, {}, ConfigError, r"scene\.kind: .*holodeck"),
        ({"object": "disk"}, {}, InputError, "neither a built-in object nor a file"),
        ({}, {"image": np.ones((32, 31))}, InputError, r"shape \(32, 31\).*\n?.*shape \(32, 32\)"),
        ({}, {"image": np.full((32, 32), 1.5)}, InputError, "1.5 to 1.5"),
        ({}, {"image": np.full((32, 32), np.nan)}, InputError, "nan"),
        ({}, {"image": np.zeros((32, 32))}, InputError, "lets light through"),
        ({}, {"path": wrong_path}, InputError, r"shape \(483,\) for 483 times"),
        ({}, {"path": broken_path}, InputError, "not all of it finite"),
        ({"object": "disc"}, {"image": IMAGE}, InputError, "object = 'disc' in the scene, and image beside it"),
        ({"trajectory": "a.csv"}, {"path": curve}, InputError, "trajectory = 'a.csv' in the scene, and path"),
    ],
)
@pytest.mark.filterwarnings("ignore:divide by zero")
def test_a_mistake_says_what_was_seen_and_what_was_expected(
    scene: dict[str, Any], arguments: dict[str, Any], error: type[InputError], says: str
) -> None:
    with pytest.raises(error, match=says):
        simulate(PLAN, scene, **arguments)


def test_a_plan_that_the_bench_cannot_carry_out_is_refused() -> None:
    with pytest.raises(PlanError):
        simulate(Plan(frames=4, image_size=1024, superpixel=1))
