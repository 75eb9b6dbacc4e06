# pyright: reportPrivateUsage=false
"""An object that leaves the field is told from a lamp that fades, and followed as long as half of it is to be seen."""

from dataclasses import replace

import numpy as np
import pytest

from instrument import Plan, Recording, analyse, simulate
from instrument.analysis.leaving import _by_leak, _changes, crossing, going_on, share_inside
from instrument.measurement import Measurement
from instrument.tracking import as_trajectory
from protocols import Floats

PLAN = Plan(frames=500, image_size=64)
NOISE = {"kind": "pixel", "sigma": 0.05, "seed": 3}


def path(time_s: Floats) -> Floats:
    """Go 46 px to the right: from column 16 on, 13 px wide, the object is out by 11 px at the end, and half out at 0.94 of it."""
    return np.stack([46 * time_s / PLAN.run_time_s, 4 * time_s / PLAN.run_time_s], axis=1)


def recorded(travel: float = 1.0, **scene: object) -> Recording:
    table = {"object": "letter-B", "object_height_px": 18, "start_px": [22.3, 28.4], "noise": NOISE, **scene}
    return simulate(PLAN, table, path=lambda time_s: travel * path(time_s))


@pytest.fixture(scope="module")
def leaves() -> Recording:
    return recorded()


def test_an_object_that_leaves_is_followed_while_half_of_it_is_to_be_seen(leaves: Recording) -> None:
    found = analyse(leaves)
    assert leaves.truth is not None
    assert found.trajectory is not None
    share = share_inside(leaves.truth.image, leaves.truth.displacement_px)
    assert share[-1] < 0.5
    seen = share >= 0.5
    error_px = (found.trajectory.displacement_px - leaves.truth.displacement_px)[seen]
    assert np.mean(error_px**2) < 0.01
    assert found.figures.psnr_db is not None
    assert found.figures.psnr_db > 25
    first = int(np.flatnonzero(share < 0.98)[0])
    told = [text for text in found.figures.found if "leaves the field" in text]
    assert len(told) == 1
    assert abs(int(told[0].split("frame ")[1].split()[0]) - first) < 15
    assert not [doubt for doubt in found.figures.doubts if "total light changed" in doubt]
    assert abs(found.figures.frames_masked - int(np.count_nonzero(~seen))) < 15


def test_a_lamp_that_fades_is_no_object_that_leaves() -> None:
    fades = recorded(0.4, led_drift_per_s=-1.0)
    assert crossing(Measurement.of(fades)) is None
    assert any("total light changed" in doubt for doubt in analyse(fades).figures.doubts)


def test_a_shutter_at_the_end_and_masked_frames_are_no_object_that_leaves(leaves: Recording) -> None:
    """By 300 of 500 frames it is wholly inside, and on its way out: frames without light, or counts, are not its doing."""
    early = leaves.first(300)
    values, valid = early.values.copy(), early.frame_valid.copy()
    values[270:], valid[270:] = 0.0, False
    assert crossing(Measurement.of(replace(early, values=values))) is None
    assert crossing(Measurement.of(replace(early, frame_valid=valid))) is None


def test_an_object_that_is_gone_in_the_end_has_left() -> None:
    """13 px wide about column 28.4, it goes 46 px: its left edge passes column 63.5 at 41.6 of them, in frame 452."""
    gone = recorded(1.0, start_px=[28.4, 28.4])
    measurement = Measurement.of(gone)
    (dark,) = [finding for finding in measurement.findings if finding.kind == "no light"]
    assert abs(dark.frames[0] - 452) < 12
    left = crossing(measurement)
    assert left is not None
    assert 280 < left.end_frame < 330


def test_in_little_light_the_whole_path_says_where_it_goes() -> None:
    """With photons as few, the last third of the path before it leaves would lead it 2 px astray, and the light disagree."""
    noise = {"kind": "poisson", "peak_counts": 400.0, "seed": 6}
    gone = recorded(1.0, start_px=[28.4, 28.4], noise=noise)
    left = crossing(Measurement.of(gone))
    assert left is not None
    assert left.fitted == 1
    assert gone.truth is not None
    half_out = int(np.flatnonzero(left.share < 0.5)[0])
    np.testing.assert_allclose(
        left.trajectory.displacement_px[half_out], gone.truth.displacement_px[half_out], atol=1.0
    )


def test_a_run_that_begins_in_the_dark_and_whose_object_leaves_counts_from_its_first_light(leaves: Recording) -> None:
    values = leaves.values.copy()
    values[:40] = 0.0
    left = crossing(Measurement.of(replace(leaves, values=values)))
    assert left is not None
    assert left.first_frame == left.trajectory.reference_frame == 41
    assert left.trajectory.displacement_px[41].tolist() == [0, 0]


def test_without_the_frames_in_which_it_leaves_nothing_is_found(leaves: Recording) -> None:
    assert crossing(Measurement.of(leaves.first(300))) is None
    left = crossing(Measurement.of(leaves))
    assert left is not None
    assert 300 < left.end_frame < 400
    assert np.array_equal(np.flatnonzero(left.whole.valid), np.arange(left.end_frame))


def test_a_part_that_leaves_in_the_last_frames_alone_is_noticed() -> None:
    """13 px wide about column 28.4, it goes 30 px: out by 1 px or two in the last 33 frames; the lamp flickers by 2 %."""
    late = recorded(30 / 46, start_px=[28.4, 28.4], led_flicker=0.02)
    assert late.truth is not None
    share = share_inside(late.truth.image, late.truth.displacement_px)
    assert 0.85 < share[-1] < 0.95
    left = crossing(Measurement.of(late))
    assert left is not None
    assert 455 < left.end_frame < 490


def test_a_lamp_that_flickers_is_no_object_that_leaves_in_the_last_frames() -> None:
    """At 100 Hz the 150 ms of the run end with a whole period: its last frames are darker than most by up to a fifth."""
    assert crossing(Measurement.of(recorded(24 / 46, start_px=[28.4, 28.4], led_flicker=0.2))) is None


def test_the_share_is_that_of_the_light_whose_pixels_are_inside() -> None:
    """Three pixels of light 1, 2 and 1 in the last columns of a field of 8, and one too dark to be the object's."""
    image = np.zeros((8, 8))
    image[3, 4:7] = [1, 2, 1]
    image[0, 0] = 0.15
    away = np.array([[0, 0], [1.4, 0], [1.6, 0], [2.6, 0], [3.6, 0], [0, 5], [0, -3.4], [0, -3.6], [-4.6, 0]])
    np.testing.assert_allclose(share_inside(image, away), [1, 1, 0.75, 0.25, 0, 0, 1, 0, 0.75])


def test_a_path_goes_on_along_its_parabola() -> None:
    frame = np.arange(100.0)
    place_px = np.stack([0.3 * frame + 0.002 * frame**2, -0.1 * frame], axis=1)
    known = place_px.copy()
    known[70:] = known[69]
    for fitted in (1, 3):
        found = going_on(as_trajectory(known, 100, 3e-4), 0, 70, fitted)
        np.testing.assert_allclose(found.displacement_px, place_px, atol=1e-9)
    known[:46] = 0.0  # of no account to its last third, frames 47 to 69
    found = going_on(as_trajectory(known, 100, 3e-4), 0, 70)
    np.testing.assert_allclose(found.displacement_px[70:], place_px[70:], atol=1e-9)


def test_an_object_that_comes_into_the_field_is_followed_from_when_half_of_it_is_inside() -> None:
    """13 px wide about column -5, it goes 46 px: its left edge passes column -0.5 at (6.5 + 4.5) / 46 of 500 frames, 120."""
    comes = recorded(start_px=[-5.0, 28.4])
    assert comes.truth is not None
    found = analyse(comes)
    path, first = found.trajectory, found.reference_frame
    assert path is not None
    assert 110 < first < 160
    assert path.displacement_px[first].tolist() == [0, 0]
    assert path.sigma_px[first].tolist() == [0, 0]
    known = np.isfinite(path.sigma_px).all(axis=1)
    truth_px = comes.truth.displacement_px - comes.truth.displacement_px[first]
    assert 35 < int(np.flatnonzero(known)[0]) < 70  # half of it is inside from frame 49 on
    assert [text.split(" until")[0] for text in found.figures.found] == ["the object comes into the field"]
    assert f"those of frame {first}" in found.figures.doubts[0]
    error_px: Floats = (path.displacement_px - truth_px)[known]
    mse_px2 = float(np.mean(error_px**2))
    assert mse_px2 < 0.01
    assert found.figures.displacement_mse_px2 == pytest.approx(mse_px2)
    assert found.truth_px is not None
    assert np.array_equal(found.truth_px, truth_px)
    assert (found.true_image, found.figures.psnr_db) == (None, None)  # that of frame 0, when it was not inside


def test_an_object_that_comes_and_goes_is_seen_in_between() -> None:
    """It goes 86 px from column -20 on: its left edge passes column -0.5, the right one column 63.5 at 26 and 77 px of them."""
    passes = recorded(86 / 46, start_px=[-20.0, 28.4])
    crossed = crossing(Measurement.of(passes))
    assert crossed is not None
    assert abs(crossed.first_frame - 500 * 26 / 86) < 30
    assert abs(crossed.end_frame - 500 * 77 / 86) < 30
    assert crossed.trajectory.reference_frame == crossed.first_frame
    assert crossed.share[0] == 0
    assert 0.25 < crossed.share[-1] < 0.45  # 4 px of 13


def test_a_lamp_that_gets_brighter_is_no_object_that_comes() -> None:
    assert crossing(Measurement.of(recorded(0.4, led_drift_per_s=1.5))) is None


def test_light_that_a_leak_makes_fall_is_no_object_that_leaves() -> None:
    """An eighth of the picture before: over 28 px the total light falls by 2 % at the end, as the fringes go."""
    plan = Plan(frames=600, image_size=64)
    scene = {
        "object": "letter-B",
        "object_height_px": 18,
        "start_px": [20.4, 22.7],
        "mirror_transition_s": 12.5e-6,
        "noise": {"kind": "pixel", "sigma": 0.02, "seed": 1},
    }
    way_px_s = np.array([28.0, 8.4]) / plan.run_time_s
    measurement = Measurement.of(simulate(plan, scene, path=lambda time_s: np.multiply.outer(time_s, way_px_s)))
    rise, fall = _changes(measurement)
    assert rise is None
    assert fall is not None
    leak = measurement.light.leak.model_copy(update={"value": 0.125})
    assert _by_leak(measurement, measurement.light.model_copy(update={"leak": leak}), rise, fall)
    assert not _by_leak(measurement, measurement.light, rise, fall)
