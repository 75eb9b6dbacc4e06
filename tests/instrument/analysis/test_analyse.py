"""The whole way from a recording: which steps each scheme, tracking and method takes, and what it leaves in the file."""

import json
from pathlib import Path

import numpy as np
import pytest

from instrument.analysis import Analysis, analyse, analyse_path, recording_to_analyse, store
from instrument.choices import Method, Tracking
from instrument.plan import Plan
from instrument.recording import Recording
from instrument.storage import RecordingWriter, open_recording
from protocols import CountBlock, Floats, InputError
from tests.support import plain_hdf5 as plain
from tests.support.objects import letter
from tests.support.plans import plan_of
from tests.support.simulation import simulate

FRAMES, SIZE = 120, 64


def line(time_s: Floats) -> Floats:
    """16 px across and 8 px up in 36 ms, the length of the run, from (10, 20) px on."""
    way: Floats = np.outer(time_s / 36e-3, [16.0, -8.0]) + np.array([10.0, 20.0])
    return way


def recorded(scheme: str = "fourier-hadamard", *, resting: bool = False) -> Recording:
    plan = plan_of(scheme, FRAMES, SIZE)
    still = np.zeros(2) if resting else np.ones(2)
    return simulate(plan, letter(SIZE, "letter-B", 24), lambda time_s: line(still[0] * time_s), sigma=0.02)


@pytest.fixture(scope="module")
def moved() -> Recording:
    return recorded()


@pytest.fixture(scope="module")
def joint(moved: Recording) -> Analysis:
    return analyse(moved, tracking="joint", method="tv")


def in_file(path: Path, recording: Recording) -> Path:
    """Write a recording as a run would."""
    with RecordingWriter(path, recording.plan, picture_time_s=recording.picture_time_s) as writer:
        writer.append_raw(CountBlock(first_bin=0, counts=recording.values.ravel()))
        writer.append(recording.values.ravel())
        writer.finish()
    return path


def test_progress_is_told_step_by_step_and_ends_at_the_total(moved: Recording) -> None:
    told: list[tuple[str, int, int]] = []
    analyse(moved, tracking="smooth", method="dgi", on_step=lambda what, done, total: told.append((what, done, total)))
    assert told == [("following the object", 0, 3), ("reconstructing", 1, 3), ("comparing", 2, 3), ("done", 3, 3)]


@pytest.mark.parametrize(
    ("tracking", "method", "path_by", "refined"),
    [("joint", "tv", "joint", True), ("smooth", "dgi", "smooth", False), ("per-frame", "dgi", "per-frame", False)],
)
def test_each_tracking_finds_the_path_in_its_own_way(
    moved: Recording, joint: Analysis, tracking: Tracking, method: Method, path_by: str, *, refined: bool
) -> None:
    found = joint if tracking == "joint" else analyse(moved, tracking=tracking, method=method)
    assert found.trajectory is not None
    assert found.trajectory.method == path_by
    assert (found.refinements > 0) is refined
    assert found.reconstruction is not None
    assert found.reconstruction.method == method
    assert found.tracking == tracking
    assert found.figures.displacement_mse_px2 is not None
    assert found.figures.displacement_mse_px2 < 0.1


def test_another_image_method_is_given_the_refined_path(moved: Recording, joint: Analysis) -> None:
    ghost = analyse(moved, method="dgi")
    assert joint.trajectory is not None
    assert ghost.trajectory is not None
    np.testing.assert_array_equal(ghost.trajectory.displacement_px, joint.trajectory.displacement_px)
    assert ghost.refinements == joint.refinements > 0
    assert ghost.reconstruction is not None
    assert ghost.reconstruction.method == "dgi"


def test_the_image_with_the_motion_ignored_is_the_inverse_transform(moved: Recording) -> None:
    found = analyse(moved, tracking="per-frame", method="conventional")
    assert found.ignored is not None
    np.testing.assert_array_equal(found.ignored, found.image)


def test_a_scheme_that_only_tracks_has_a_path_and_no_image() -> None:
    found = analyse(recorded("fourier-3step"))
    assert found.trajectory is not None
    assert found.image is None
    assert found.ignored is None
    assert found.reconstruction is None
    assert (found.refinements, found.figures.misfit, found.figures.psnr_db) == (0, None, None)


def test_a_scheme_without_position_has_an_image_and_no_path() -> None:
    found = analyse(recorded("hadamard", resting=True))
    assert found.trajectory is None
    assert found.image is not None
    assert found.image.shape == (SIZE, SIZE)
    assert (found.refinements, found.figures.travel_px, found.figures.sigma_px) == (0, None, None)


def test_wrong_names_and_empty_recordings_are_refused_before_any_work(moved: Recording) -> None:
    with pytest.raises(InputError, match="saw the tracking 'both'; expected one of joint, smooth, per-frame"):
        analyse(moved, tracking="both")  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]
    with pytest.raises(InputError, match="tval4"):
        analyse(moved, method="tval4")  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]
    nothing = Recording(moved.plan, moved.values, np.zeros(FRAMES, np.bool_), 50e-6)
    with pytest.raises(InputError, match="saw 120 frames, none of them valid"):
        analyse(nothing)


def test_frames_left_out_at_the_end_are_nan() -> None:
    padded = Analysis.padded(np.array([[1.0, 2.0], [3.0, 4.0]]), 4)
    np.testing.assert_array_equal(padded, [[1, 2], [3, 4], [np.nan, np.nan], [np.nan, np.nan]])


def test_the_file_gets_path_image_figures_and_how_they_were_made(moved: Recording, tmp_path: Path) -> None:
    path = in_file(tmp_path / "run.h5", moved)
    figures = analyse_path(path, tracking="smooth", method="dgi", frames=90)
    found = plain.array(path, "entry/analysis/track/displacement_px")
    sigma = plain.array(path, "entry/analysis/track/sigma_px")
    assert np.isfinite(found).all(axis=1).tolist() == [True] * 90 + [False] * 30
    assert np.isfinite(sigma).all(axis=1).tolist() == [True] * 90 + [False] * 30
    assert tuple(found[89].tolist()) == figures.travel_px
    assert plain.array(path, "entry/analysis/image/image").shape == (SIZE, SIZE)
    assert json.loads(plain.text(path, "entry/analysis/table")) == figures.model_dump(mode="json")
    assert json.loads(plain.text(path, "entry/analysis/settings")) == {
        "tracking": "smooth",
        "method": "dgi",
        "frames": 90,
        "refinements": 0,
        "grid": 1,
    }


def test_what_a_scheme_does_not_have_is_not_in_the_file(tmp_path: Path) -> None:
    tracks = in_file(tmp_path / "tracks.h5", recorded("fourier-3step"))
    analyse_path(tracks)
    images = in_file(tmp_path / "images.h5", recorded("hadamard", resting=True))
    analyse_path(images, method="conventional")
    with plain.opened(tracks) as file:
        assert "track" in file["entry/analysis"]
        assert "image" not in file["entry/analysis"]
    assert json.loads(plain.text(tracks, "entry/analysis/settings"))["method"] is None
    with plain.opened(images) as file:
        assert "image" in file["entry/analysis"]
        assert "track" not in file["entry/analysis"]


def test_a_background_is_taken_off_and_the_counts_stay(moved: Recording, tmp_path: Path) -> None:
    behind = Recording(moved.plan, np.full_like(moved.values, 7.0), moved.frame_valid, 50e-6)
    run, empty = in_file(tmp_path / "run.h5", moved), in_file(tmp_path / "empty.h5", behind)
    assert recording_to_analyse(run).background is None
    taken = recording_to_analyse(run, empty)
    assert taken.background is not None
    np.testing.assert_array_equal(taken.background, 7.0)
    store(run, taken, analyse(taken, tracking="per-frame", method="conventional"))
    np.testing.assert_array_equal(open_recording(run).values, moved.values)


def test_the_name_of_a_file_is_as_good_as_its_recording(moved: Recording, tmp_path: Path) -> None:
    path = in_file(tmp_path / "run.h5", moved.first(12))
    by_name, by_path = (analyse(name, tracking="per-frame", method="conventional") for name in (str(path), path))
    assert by_name.recording.path == path
    assert by_name.trajectory is not None
    assert by_path.trajectory is not None
    np.testing.assert_array_equal(by_name.trajectory.displacement_px, by_path.trajectory.displacement_px)
    with pytest.raises(InputError, match="no such file"):
        analyse("none.h5")


def test_an_analysis_of_a_plan_that_goes_on_is_as_long_as_the_recording(moved: Recording) -> None:
    part = moved.first(12)
    assert isinstance(part.plan, Plan)
    found = analyse(part, tracking="per-frame", method="conventional")
    assert found.trajectory is not None
    assert (len(found.trajectory), found.figures.frames) == (12, 12)
