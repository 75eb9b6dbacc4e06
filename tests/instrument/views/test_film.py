"""The film of a run: its pictures, its files, and what is refused."""

import importlib
import sys
from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageSequence

from instrument.analysis import Analysis, analyse, forming
from instrument.cli.main import status
from instrument.plan import Plan
from instrument.session import Instrument, simulate
from instrument.views import write_film
from protocols import Floats, InputError
from tests.support.benches import SMALL, bench_toml

PLAN = Plan(frames=80, image_size=32)


def path(time_s: Floats) -> Floats:
    way: Floats = np.stack([200.0 * time_s, 100.0 * time_s], axis=1)
    return way


@pytest.fixture(scope="module")
def analysis() -> Analysis:
    scene = {"object_height_px": 12, "start_px": [8, 8], "noise": {"kind": "pixel", "sigma": 0.02, "seed": 1}}
    return analyse(simulate(PLAN, scene, path=path), tracking="smooth", grid="1")


def test_the_image_forms_from_more_and_more_frames(analysis: Analysis) -> None:
    stages = list(forming(analysis, 4))
    assert [stage.frames for stage in stages] == [8, 32, 56, 80]
    truth = analysis.recording.truth
    assert truth is not None
    error = [float(np.mean((stage.image - truth.image) ** 2)) for stage in stages]
    assert error[0] > 2 * error[-1]
    np.testing.assert_array_equal(stages[-1].image, analysis.image)
    with pytest.raises(InputError, match="at least 2"):
        next(forming(analysis, 1))


def test_a_gif_shows_the_object_move_and_holds_its_last_picture(analysis: Analysis, tmp_path: Path) -> None:
    told: list[tuple[int, int]] = []
    film = write_film(
        analysis, tmp_path / "a.gif", pictures=3, on_picture=lambda done, total: told.append((done, total))
    )
    with Image.open(film) as opened:
        frames = [np.asarray(frame.convert("L"), np.float64) for frame in ImageSequence.Iterator(opened)]
        assert opened.size == (960, 580)
    assert told == [(1, 3), (2, 3), (3, 3)]
    assert len(frames) == 3  # a GIF joins pictures that are equal
    field = [frame[60:370, 60:420] for frame in frames]
    assert np.abs(field[0] - field[2]).max() > 100  # it has moved
    assert [item.name for item in tmp_path.iterdir()] == ["a.gif"]


def test_an_mp4_has_a_second_more_than_its_pictures(analysis: Analysis, tmp_path: Path) -> None:
    library = importlib.import_module("imageio_ffmpeg")
    film = write_film(analysis, tmp_path / "a.mp4", pictures=2)
    frames, seconds = library.count_frames_and_secs(str(film))
    assert frames == 1 + 15
    assert seconds == pytest.approx(16 / 15, abs=0.02)


def test_without_its_library_an_mp4_is_refused_before_any_work(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    assert status(["film", str(tmp_path / "none.h5"), "--out", str(tmp_path / "a.mp4")]) == 2
    said = " ".join(capsys.readouterr().err.split())
    assert "pip install 'kinopix[film]', or name a .gif" in said


def test_the_command_writes_a_film_beside_the_recording_and_replaces_none(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        bench.run(SMALL, tmp_path / "run.h5")
    assert status(["film", str(tmp_path / "run.h5"), "--pictures", "2"]) == 0
    assert "written" in capsys.readouterr().out
    assert (tmp_path / "run.gif").is_file()
    assert status(["film", str(tmp_path / "run.h5"), "--pictures", "2"]) == 2
    assert status(["film", str(tmp_path / "run.h5"), "--pictures", "2", "--overwrite"]) == 0
    assert status(["film", str(tmp_path / "run.h5"), "--out", str(tmp_path / "run.avi")]) == 2
    assert "ends in .mp4 or .gif" in " ".join(capsys.readouterr().err.split())


def test_a_scheme_without_an_image_has_no_film(tmp_path: Path) -> None:
    only_tracks = Plan.model_validate({"frames": 40, "image_size": 32, "scheme": "fourier-3step"})
    found = analyse(simulate(only_tracks, path=path))
    with pytest.raises(InputError, match="gives no path or no image"):
        write_film(found, tmp_path / "a.gif")
    assert list(tmp_path.iterdir()) == []
