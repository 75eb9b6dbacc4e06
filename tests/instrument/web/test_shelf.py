"""Past recordings of a folder, and the pictures beside them."""

import os
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from instrument.session import Instrument
from instrument.storage import stored_analysis, write_analysis
from instrument.web import Shelf
from protocols import InputError
from tests.support.benches import SMALL, bench_toml


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A recording with an analysis and a picture, one without, and a file that is none."""
    folder = tmp_path_factory.mktemp("shelf")
    with Instrument.from_toml(bench_toml(folder, 'object = "letter-B"')) as bench:
        bench.run(SMALL, folder / "old.h5")
        bench.run(SMALL, folder / "new.h5")
    places = np.stack([np.arange(40.0), 2 * np.arange(40.0)], axis=1)
    places[39] = np.nan
    write_analysis(
        folder / "old.h5",
        displacement_px=places,
        sigma_px=np.full((40, 2), 0.25),
        displacement_mm=places / 10,
        image=np.eye(4),
        table={"sigma_px": 0.25, "doubts": ["too little light"]},
    )
    Image.new("L", (4, 3)).save(folder / "old-summary.png")
    (folder / "old-image.png").write_bytes(b"no picture")
    (folder / "broken.h5").write_bytes(b"no recording")
    (folder / ".hidden.h5").write_bytes(b"")
    for age_s, name in enumerate(("new.h5", "broken.h5", "old.h5")):
        os.utime(folder / name, (1e9 - age_s, 1e9 - age_s))
    return folder


def test_recordings_are_listed_the_newest_first_with_what_they_are(folder: Path) -> None:
    new, broken, old = Shelf(folder).recordings()
    assert [line["name"] for line in (new, broken, old)] == ["new.h5", "broken.h5", "old.h5"]
    assert (new["state"], new["frames"], new["verdict"], new["analysed"]) == ("complete", 40, "good", None)
    assert new["pictures"] == []
    assert "broken.h5" in broken["error"]
    assert old["analysed"] is not None
    assert (old["pictures"], old["doubts"], old["sigma_px"]) == (["summary", "image"], ["too little light"], 0.25)


def test_one_recording_comes_with_its_path_and_its_uncertainty(folder: Path) -> None:
    path = (Shelf(folder).recording("old.h5") or {})["path"]
    assert path["px"][:2] == [[0.0, 0.0], [1.0, 2.0]]
    assert path["sigma_px"][5] == [0.25, 0.25]
    assert path["px_per_mm"] == pytest.approx(10.0)
    assert path["time_s"][1] == pytest.approx(4.5e-4)
    assert (Shelf(folder).recording("new.h5") or {})["path"] is None


def test_without_a_stated_uncertainty_none_is_shown(tmp_path: Path) -> None:
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        bench.run(SMALL, tmp_path / "few.h5")
    px = np.zeros((40, 2))
    write_analysis(tmp_path / "few.h5", displacement_px=px, sigma_px=px + 1, image=None, table={"sigma_px": None})
    assert "sigma_px" not in (Shelf(tmp_path).recording("few.h5") or {})["path"]


def test_a_long_path_is_thinned_out(folder: Path, tmp_path: Path) -> None:
    plan = SMALL.model_copy(update={"frames": 1700, "image_size": 8, "superpixel": 8, "motion": None})
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        bench.run(plan, tmp_path / "long.h5")
    write_analysis(tmp_path / "long.h5", displacement_px=np.zeros((1700, 2)), image=None)
    assert len((Shelf(tmp_path).recording("long.h5") or {})["path"]["px"]) == 850


@pytest.mark.parametrize("name", ["../old.h5", "old", "none.h5", "", ".", "broken.h5/..", "OLD.h5\x00"])
def test_no_name_leads_out_of_the_folder(folder: Path, name: str) -> None:
    shelf = Shelf(folder)
    assert shelf.recording(name) is None
    assert shelf.picture(name, "summary") is None


def test_only_pictures_that_analyses_draw_are_given_and_only_where_they_are_some(folder: Path) -> None:
    shelf = Shelf(folder)
    assert shelf.picture("old.h5", "summary") == folder / "old-summary.png"
    assert shelf.picture("old.h5", "image") is None
    assert shelf.picture("old.h5", "../old-summary") is None
    assert shelf.picture("new.h5", "summary") is None


def test_while_a_run_goes_on_no_file_is_read_that_was_not_known(folder: Path) -> None:
    quiet = True
    shelf = Shelf(folder, lambda: quiet)
    known = shelf.recordings()
    quiet = False
    assert shelf.recordings()[0] == known[0]
    assert [line.get("unread") for line in Shelf(folder, lambda: False).recordings()] == [True, True, True]
    assert "path" not in (shelf.recording("old.h5") or {})


def test_a_file_that_changed_is_read_anew(tmp_path: Path) -> None:
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        bench.run(SMALL, tmp_path / "run.h5")
    shelf = Shelf(tmp_path)
    assert shelf.recordings()[0]["analysed"] is None
    write_analysis(tmp_path / "run.h5", displacement_px=np.zeros((40, 2)), image=None)
    assert shelf.recordings()[0]["analysed"] is not None


def test_a_folder_that_is_not_there_is_refused(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="no folder"):
        Shelf(tmp_path / "none")


def test_the_arrays_of_an_analysis_are_given_as_they_were_stored(folder: Path) -> None:
    stored = stored_analysis(folder / "old.h5")
    assert stored is not None
    assert stored.image is not None
    assert stored.image.tolist() == np.eye(4).tolist()
    assert stored.displacement_mm is not None
    assert stored.displacement_mm[3].tolist() == [pytest.approx(0.3), pytest.approx(0.6)]
    assert (stored.angle_deg, stored.still, stored.sigma_mm) == (None, None, None)
    assert stored_analysis(folder / "new.h5") is None
