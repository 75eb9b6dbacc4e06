"""A run in windows: one path over all of it, images of its windows, and no more of the file read than a window."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from instrument.analysis import Windowed, analyse_in_windows
from instrument.cli.main import status
from instrument.numerics import psnr
from instrument.plan import Plan
from instrument.recording import Recording
from instrument.storage import RecordingWriter, open_recording
from instrument.tracking import JoinedPath, Trajectory, Window, track, windows_of
from instrument.views import write_window_film, write_window_pictures
from protocols import Floats, InputError
from tests.support.objects import letter
from tests.support.plain_hdf5 import array, opened
from tests.support.simulation import simulate

SIZE, FRAMES = 32, 3400


def test_windows_are_whole_cycles_and_share_one() -> None:
    assert windows_of(1100, 300, 256) == [Window(0, 512, 0), Window(256, 1100, 512)]
    assert windows_of(1100, 256, 256)[1:3] == [Window(0, 512, 256), Window(256, 768, 512)]
    assert windows_of(1100, 256, 256)[-1] == Window(512, 1100, 768)  # what is left is less than a cycle
    assert windows_of(1024, 256, 256)[-1] == Window(512, 1024, 768)
    assert windows_of(100, 50_000, 256) == windows_of(100, 1, 256) == [Window(0, 100, 0)]
    with pytest.raises(InputError, match="windows of 0 frames"):
        windows_of(100, 0, 256)


def _path(place_px: Floats, sigma_px: float) -> Trajectory:
    both = np.stack([place_px, -place_px], axis=1)
    return Trajectory(both - both[0], np.full_like(both, sigma_px), 0.1, "smooth", np.ones(len(both), np.bool_))


def test_paths_are_joined_in_what_they_share_and_their_ends_are_left_out() -> None:
    """Each path goes astray in the 2 frames at its ends, by 1 px, and is relative to its own first frame."""
    truth = np.sin(np.arange(40) / 7) * 5
    joined = JoinedPath(40)
    for window in (Window(0, 24, 0), Window(16, 40, 24)):
        astray = truth[window.first : window.end].copy()
        if window.first:
            astray[:2] += 1.0
        if window.end < 40:
            astray[-2:] += 1.0
        start = joined.add(window, _path(astray, 0.1 if window.first == 0 else 0.2))
    found = joined.trajectory(0.1)
    np.testing.assert_allclose(found.displacement_px[:, 0], truth - truth[0], atol=1e-12)
    np.testing.assert_allclose(found.displacement_px[:, 1], truth[0] - truth, atol=1e-12)
    np.testing.assert_allclose(start, [truth[16] + 1 - truth[0], truth[0] - truth[16] - 1], atol=1e-12)
    assert found.sigma_px[[19, 20], 0].tolist() == [0.1, 0.2]  # in the middle of what both share
    assert len(found) == 40
    assert found.valid.all()


@pytest.fixture(scope="module")
def recorded(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A "B" that goes round in a field of 32 x 32: three cycles of its patterns, and a part of one."""
    plan = Plan(frames=FRAMES, image_size=SIZE)

    def path(time_s: Floats) -> Floats:
        angle = 2 * np.pi * 1.3 * time_s / plan.run_time_s
        return np.stack([4 * (1 - np.cos(angle)), 3 * np.sin(angle)], axis=1)

    image = np.roll(letter(SIZE, "letter-B", 9), (9, 7), axis=(0, 1))
    run = simulate(plan, image, path, sigma=0.1, seed=1)
    file = tmp_path_factory.mktemp("long") / "run.h5"
    with RecordingWriter(file, plan, picture_time_s=plan.picture_time_s, with_truth=True) as writer:
        writer.append(run.values.ravel(), np.arange(run.values.size, dtype=np.float64) * plan.picture_time_s)
        writer.finish(truth=run.truth)
    return file


@pytest.fixture(scope="module")
def windowed(recorded: Path) -> Windowed:
    return analyse_in_windows(recorded, window_frames=1500, images=[1], results=recorded.with_name("analysed.h5"))


def test_the_path_is_true_over_all_windows_and_images_are_where_the_object_was_at_the_start(
    recorded: Path, windowed: Windowed
) -> None:
    truth = open_recording(recorded).truth
    assert truth is not None
    error_px = windowed.trajectory.displacement_px - truth.displacement_px
    of_whole_px = track(open_recording(recorded)).displacement_px - truth.displacement_px
    assert np.mean(error_px**2) < 1.1 * np.mean(of_whole_px**2)
    of_imaged_px: Floats = error_px[1600:] - error_px[1600:].mean(
        axis=0
    )  # refined with its image, from the middle of what is shared
    assert float(np.sqrt(np.mean(of_imaged_px**2))) < 0.05
    assert windowed.figures.displacement_mse_px2 == pytest.approx(float(np.mean(error_px**2)))
    assert windowed.figures.light_change < 0.02
    assert windowed.figures.sigma_px == pytest.approx(float(np.median(windowed.trajectory.sigma_px)))
    assert windowed.windows == (Window(0, 2048, 0), Window(1024, 3400, 2048))
    (second,) = windowed.images
    assert second.window == windowed.windows[1]
    assert psnr(second.image, truth.image) > 25
    assert second.misfit < 1.3


def test_the_file_has_the_path_and_the_image_of_each_window(windowed: Windowed, recorded: Path) -> None:
    file = recorded.with_name("analysed.h5")
    np.testing.assert_array_equal(
        array(file, "/entry/analysis/track/displacement_px"), windowed.trajectory.displacement_px
    )
    np.testing.assert_array_equal(array(file, "/entry/analysis/windows/image"), [windowed.images[0].image])
    assert array(file, "/entry/analysis/windows/frames").tolist() == [[1024, 3400]]
    assert array(file, "/entry/analysis/windows/x_px").tolist() == list(range(SIZE))


def written(path: Path, plan: Plan, values: Floats) -> Path:
    """A recording of these values."""
    with RecordingWriter(path, plan, picture_time_s=plan.picture_time_s) as writer:
        writer.append(values.ravel())
        writer.finish()
    return path


@pytest.fixture(scope="module")
def behind() -> Recording:
    """A disc that stands still, with as much light as the "B": the same patterns, for a cycle and more, without noise."""
    plan = Plan(frames=2400, image_size=SIZE)
    y, x = np.mgrid[:SIZE, :SIZE]
    disc = ((x - 22) ** 2 + (y - 10) ** 2 < 16).astype(np.float64)
    return simulate(plan, disc, lambda time_s: np.zeros((len(time_s), 2)))


@pytest.fixture(scope="module")
def in_front(recorded: Path, behind: Recording) -> Path:
    """The "B" in front of it. What stands still is the same in every cycle of 1,024 frames."""
    run = open_recording(recorded)
    still = np.tile(behind.values[:1024], (4, 1))[:FRAMES]
    return written(recorded.with_name("in-front.h5"), run.plan, run.values + still)


def test_a_background_that_is_as_long_as_a_window_is_subtracted_from_all(
    recorded: Path, in_front: Path, behind: Recording, tmp_path: Path
) -> None:
    truth = open_recording(recorded).truth
    assert truth is not None
    empty = written(tmp_path / "empty.h5", behind.plan, behind.values)

    def error_px2(background: str | Path, name: str) -> float:
        found = analyse_in_windows(
            in_front, window_frames=1500, images=[], background=background, results=tmp_path / name
        )
        return float(np.mean((found.trajectory.displacement_px - truth.displacement_px) ** 2))

    alone_px2 = float(np.mean((track(open_recording(recorded)).displacement_px - truth.displacement_px) ** 2))
    assert error_px2(empty, "a.h5") < 1.1 * alone_px2
    assert error_px2("none", "b.h5") > 1.2 * alone_px2

    short = written(tmp_path / "short.h5", behind.plan.model_copy(update={"frames": 2300}), behind.values[:2300])
    with pytest.raises(InputError, match=r"a background of 2300 frames, .*; expected as many as a window has, 2376"):
        error_px2(short, "c.h5")


def test_a_background_that_is_longer_is_that_of_the_same_frames(
    recorded: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """As long as the run, frame by frame; shorter, from its first frame on."""
    asked: list[tuple[int, int]] = []
    plan = Plan(frames=FRAMES, image_size=SIZE)
    whole = written(tmp_path / "whole.h5", plan, np.zeros((FRAMES, plan.patterns_per_frame)))
    part = written(
        tmp_path / "part.h5", plan.model_copy(update={"frames": 3399}), np.zeros((3399, plan.patterns_per_frame))
    )

    def read(path: Path, frames: tuple[int, int]) -> Recording:
        if path in {whole, part}:
            asked.append(frames)
        return open_recording(path, frames)

    monkeypatch.setattr("instrument.analysis.windows.open_recording", read)
    for background in (whole, part):
        results = tmp_path / f"of-{background.name}"
        analyse_in_windows(recorded, window_frames=1500, images=[], background=background, results=results)
    assert asked == [(0, 2048), (1024, 3400), (0, 2048), (0, 2376)]


def test_what_stands_still_is_found_with_the_object_and_drawn(in_front: Path, tmp_path: Path) -> None:
    """Both have as much light; the disc is at (22, 10)."""
    done = analyse_in_windows(in_front, window_frames=1500, images=[1], background="fit", results=tmp_path / "found.h5")
    still = array(tmp_path / "found.h5", "/entry/analysis/background/background")
    (image,) = done.images
    np.testing.assert_array_equal(still, image.still)
    y, x = np.mgrid[:SIZE, :SIZE]
    inside = (x - 22) ** 2 + (y - 10) ** 2 < 16
    assert still[inside].sum() / still.sum() > 0.7
    assert done.figures.background_share == pytest.approx(still.sum() / (still.sum() + image.image.sum()))
    drawn = write_window_pictures(done, tmp_path / "pictures", "run")
    assert [path.name for path in drawn] == ["run-trajectory.png", "run-windows.png", "run-background.png"]


def test_windows_that_there_are_not_are_refused(recorded: Path) -> None:
    with pytest.raises(InputError, match="windows from 0 on, before 2"):
        analyse_in_windows(recorded, window_frames=1500, images=[2])


def test_the_command_tracks_in_windows(recorded: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    results = tmp_path / "copy.h5"
    options = ["--window", "1500", "--window-images", "none", "--results", str(results)]
    assert status(["analyse", str(recorded), *options]) == 0
    assert "3400, 0 masked" in capsys.readouterr().out
    assert {path.name for path in tmp_path.iterdir()} == {"copy.h5", "copy-trajectory.png", "copy-error.png"}
    assert array(results, "/entry/analysis/track/displacement_px").shape == (FRAMES, 2)
    assert status(["analyse", str(recorded), "--window", "1500", "--window-images", "7"]) == 2
    assert "before 2" in capsys.readouterr().err
    assert status(["analyse", str(recorded), "--window", "1500", "--window-images", "one", "--no-pictures"]) == 2
    assert "all, none, or numbers" in capsys.readouterr().err
    assert (
        status(["analyse", str(recorded), str(recorded), "--window", "9", "--method", "dgi", "--mean-filter", "5"]) == 2
    )
    assert "--window with several recordings, --method, --mean-filter;" in capsys.readouterr().err.replace("\n", " ")


@pytest.mark.parametrize("frames", [(0, 5), (100, 300), (1024, 3400), (150, 160)])
def test_a_part_of_a_recording_is_that_part_of_the_whole(recorded: Path, frames: tuple[int, int]) -> None:
    part, whole = open_recording(recorded, frames), open_recording(recorded)
    other = whole.part(*frames)
    rows = slice(*frames)
    for own in (part, other):
        np.testing.assert_array_equal(own.values, whole.values[rows])
        np.testing.assert_array_equal(own.frame_valid, whole.frame_valid[rows])
        assert own.edge_time_s is not None
        assert whole.edge_time_s is not None
        np.testing.assert_array_equal(own.edge_time_s, whole.edge_time_s[rows])
        assert own.truth is not None
        assert whole.truth is not None
        np.testing.assert_array_equal(own.truth.displacement_px, whole.truth.displacement_px[rows])


@pytest.mark.parametrize("frames", [(-1, 5), (5, 5), (1000, 3401)])
def test_frames_that_a_recording_does_not_have_are_refused(recorded: Path, frames: tuple[int, int]) -> None:
    with pytest.raises(InputError, match="before 3400"):
        open_recording(recorded, frames)
    with pytest.raises(InputError, match="before 3400"):
        open_recording(recorded).part(*frames)


@pytest.mark.parametrize(
    ("frames", "refused"), [((100, 400), True), ((0, 3400), True), ((150, 420), False), ((300, 3400), False)]
)
def test_checksums_of_the_blocks_that_lie_inside_are_looked_at(
    recorded: Path, tmp_path: Path, frames: tuple[int, int], *, refused: bool
) -> None:
    """A value of frame 123 was changed: of the block from 100 to 199."""
    changed = tmp_path / "changed.h5"
    changed.write_bytes(recorded.read_bytes())
    with opened(changed, "r+") as file:
        file["/entry/data/values"][123, 2] += 1.0
    read: Callable[[], object] = lambda: open_recording(changed, frames)  # noqa: E731
    if refused:
        with pytest.raises(InputError, match="values of frames 100 to 199 that were changed"):
            read()
    else:
        read()


def test_the_windows_make_a_film(windowed: Windowed, tmp_path: Path) -> None:
    film = write_window_film(windowed, tmp_path / "windows.gif")
    with Image.open(film) as pictures:
        assert pictures.size == (640, 720)
    assert [path.name for path in tmp_path.iterdir()] == ["windows.gif"]
    with pytest.raises(InputError, match="no image was made"):
        write_window_film(replace(windowed, images=()), film)
