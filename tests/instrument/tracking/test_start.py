"""The absolute position: the object's centroid at frame 0, in px of the field."""

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from instrument import simulate
from instrument.analysis import analyse
from instrument.measurement import Measurement
from instrument.recording import Recording
from instrument.tracking import track, with_start
from protocols import Floats
from sim_backends.bench.objects import BUILT_INS
from tests.support.plans import plan_of

LINE = np.arange(64)


def centroid_px(image: Floats) -> Floats:
    along: Floats = np.array([float(image.sum(axis=0) @ LINE), float(image.sum(axis=1) @ LINE)])
    return along / float(image.sum())


def letter(top: int, left: int, height_px: int = 20) -> Floats:
    cells = BUILT_INS["letter-B"](height_px).cells
    image = np.zeros((64, 64))
    image[top : top + cells.shape[0], left : left + cells.shape[1]] = cells
    return image


def run(
    image: Floats,
    scheme: str = "fourier-hadamard",
    *,
    sigma: float = 0.0,
    frames: int = 160,
    cycles: int = 2,
    seed: int = 0,
    **scene: Any,
) -> tuple[Recording, Floats]:
    """A run 10 px to the right and 5 px up, and the true centroid at frame 0."""
    settings = {"moment_frames": 64, "fourier_cycles": cycles} if scheme == "fourier-hadamard" else {}
    plan = plan_of(scheme, frames=frames, image_size=64, **settings)

    def path(time_s: Floats) -> Floats:
        return np.outer(time_s / plan.run_time_s, [10.0, -5.0])

    noise = {"kind": "pixel", "sigma": sigma, "seed": seed} if sigma else {"kind": "none"}
    recording = simulate(plan, {"noise": noise, **scene}, image=image, path=path)
    assert recording.truth is not None
    return recording, centroid_px(recording.truth.image)


@pytest.mark.parametrize(("top", "left"), [(6, 0), (35, 33), (20, 15), (6, 33)])
def test_the_first_centroid_is_found_anywhere_in_the_field_at_the_papers_noise(top: int, left: int) -> None:
    """0.1 on every pixel, 480 px of light: a frame has 64 (2 x 20.5)^(1/2) / (2 x 480) = 0.43 px, 32 frames an axis 0.08 px.

    Dithering adds 0.1 px.
    """
    recording, truth_px = run(letter(top, left, 28), sigma=0.1, seed=top + left, cycles=1)

    found = track(recording)

    assert found.start_px is not None
    assert found.start_sigma_px is not None
    assert np.abs(found.start_px - truth_px).max() < 0.5
    assert (found.start_sigma_px > 0.07).all()
    assert (found.start_sigma_px < 0.3).all()


def test_without_noise_only_the_ramps_own_dithering_is_left() -> None:
    recording, truth_px = run(letter(20, 25))
    for method in ("smooth", "per-frame"):
        found = track(recording, method).start_px
        assert found is not None
        np.testing.assert_allclose(found, truth_px, atol=0.2)


@pytest.mark.parametrize("scheme", ["moment", "moment-complementary", "moment-hadamard"])
def test_moments_know_where_the_object_is(scheme: str) -> None:
    """Two dithering samples a side: error diffusion is within 0.4 px on the average of some columns."""
    recording, truth_px = run(letter(20, 25), scheme)
    found = track(recording).start_px
    assert found is not None
    np.testing.assert_allclose(found, truth_px, atol=0.4)
    assert track(recording, reference_frame=20).start_px is None  # it is the centroid's place at frame 0


def test_phases_alone_do_not() -> None:
    plan = plan_of("fourier-3step", frames=40, image_size=64)
    recording = simulate(plan, image=letter(20, 25), path=lambda time_s: np.zeros((len(time_s), 2)))
    assert track(recording).start_px is None
    assert track(recording).start_sigma_px is None


def test_edge_loss_that_nobody_knows_of_does_not_move_it() -> None:
    """It takes 4 % of the light of half-lit ramps here, which would pull a centroid 20 px from the middle by 0.8 px."""
    recording, truth_px = run(letter(6, 38), edge_loss=0.04)
    found = track(recording).start_px
    assert found is not None
    np.testing.assert_allclose(found, truth_px, atol=0.3)


def test_a_leak_that_is_given_is_taken_out_and_what_is_not_known_of_it_is_stated() -> None:
    recording, truth_px = run(letter(6, 38), mirror_transition_s=8e-6)
    measurement = Measurement.of(recording)
    leak = measurement.light.leak.model_copy(update={"value": 0.08, "source": "given"})
    known = measurement.lit_by(measurement.light.model_copy(update={"leak": leak}))
    found = track(known)
    assert found.start_px is not None
    assert found.start_sigma_px is not None
    np.testing.assert_allclose(found.start_px, truth_px, atol=0.3)

    unsure = replace(known, light=known.light.model_copy(update={"leak": leak.model_copy(update={"sigma": 0.02})}))
    wider = with_start(unsure, found).start_sigma_px
    assert wider is not None
    assert (wider > found.start_sigma_px + 0.05).all()


def test_a_background_is_taken_off_where_its_image_is_known() -> None:
    """A letter that stands still, as bright as the object: the centroid of all light is some 15 px away."""
    background = np.zeros((64, 64))
    background[4:20, 48:60] = 0.5
    plan = plan_of("fourier-hadamard", frames=160, image_size=64, moment_frames=64)

    def seen(image: Floats, way_px: tuple[float, float]) -> Recording:
        return simulate(plan, image=image, path=lambda time_s: np.outer(time_s / plan.run_time_s, way_px))

    alone, still = seen(letter(34, 10), (10.0, -5.0)), seen(background, (0.0, 0.0))
    both = replace(alone, values=alone.values + still.values)
    measurement = Measurement.of(both)
    path = track(alone)

    pulled, freed = (with_start(measurement, path, still=known).start_px for known in (None, background))

    assert pulled is not None
    assert freed is not None
    assert alone.truth is not None
    truth_px = centroid_px(alone.truth.image)
    assert np.abs(pulled - truth_px).min() > 5
    np.testing.assert_allclose(freed, truth_px, atol=0.3)


def test_frames_that_were_not_measured_are_left_out() -> None:
    recording, truth_px = run(letter(20, 25))
    valid = recording.frame_valid.copy()
    valid[3:40] = False
    values = recording.values.copy()
    values[3:40] = 1e3
    found = track(replace(recording, frame_valid=valid, values=values)).start_px
    assert found is not None
    np.testing.assert_allclose(found, truth_px, atol=0.3)
    nothing = replace(recording, frame_valid=np.arange(len(recording)) >= 64)
    assert track(nothing).start_px is None


def test_the_image_says_how_much_the_dithering_is_off() -> None:
    """The true image takes the dithering off to the last digit; half of its height, at the wrong place, does not."""
    recording, truth_px = run(letter(20, 25))
    assert recording.truth is not None
    measurement, path = (
        Measurement.of(recording),
        replace(track(recording), displacement_px=recording.truth.displacement_px),
    )

    rough, exact = (with_start(measurement, path, image=image).start_px for image in (None, recording.truth.image))

    assert rough is not None
    assert exact is not None
    assert np.abs(rough - truth_px).max() > 0.02
    np.testing.assert_allclose(exact, truth_px, atol=0.005)


def test_an_analysis_states_it_and_how_far_off_it_is() -> None:
    recording, truth_px = run(letter(20, 25), sigma=0.02)
    analysis = analyse(recording)

    assert analysis.trajectory is not None
    assert analysis.trajectory.start_px is not None
    assert analysis.figures.start_px == tuple(analysis.trajectory.start_px.tolist())
    off = float(np.hypot(*(analysis.trajectory.start_px - truth_px)))
    assert analysis.figures.start_error_px == pytest.approx(off)
    assert off < 0.3
    assert f"(off by {off:.2f})" in analysis.figures.rows()["centroid at frame 0"]
