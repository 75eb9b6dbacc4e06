"""Files of other programs, as recordings: written here as those programs write them, and measured ones where they are."""

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from instrument.acquisition import check_recording
from instrument.cli.main import status
from instrument.foreign import convert, read_array, read_spas
from instrument.foreign.pairs import ORDERS
from instrument.patterns import HadamardOrder, hadamard_order, hadamard_signs
from instrument.reconstruction import inverse_hadamard
from instrument.schemes import scheme_of
from instrument.storage import open_recording, recording_info
from protocols import Floats, InputError, Integers
from tests.support.measured import MEASURED

SIZE = 8
IMAGE = np.random.default_rng(3).random((SIZE, SIZE))
"""What was looked at, row = y (down): no two of its turns and mirrors are alike."""


def image_of(path: Path) -> Floats:
    """The image by the inverse transform, from the pairs and from the scheme's own idea of what each frame shows."""
    recording = open_recording(path)
    rows = scheme_of(recording.plan).image_rows
    assert rows is not None
    good = recording.frame_valid
    difference = recording.values[:, 0] - recording.values[:, 1]
    return np.asarray(inverse_hadamard(difference[good], rows.pairs[good], recording.plan.image_size))


def light_of(pairs: Integers) -> Floats:
    """``(2 n,)``: light of each pattern and of its complement, in turn."""
    signs = hadamard_signs(SIZE, pairs).reshape(len(pairs), -1)
    lit = np.stack([signs > 0, signs < 0], axis=1).reshape(-1, SIZE * SIZE)
    return np.asarray(lit.astype(float) @ IMAGE.ravel())


def walsh_2d() -> Any:
    """Rows of Walsh functions by sign changes, and of the plane by Kronecker's product: by definition, not by our own code."""
    rows = np.ones((1, 1))
    while len(rows) < SIZE:
        rows = np.block([[rows, rows], [rows, -rows]])
    rows = rows[np.argsort((np.diff(rows, axis=1) != 0).sum(axis=1))]
    return np.kron(rows, rows)


def spas_pair(folder: Path, rows: list[int], name: str = "cat_whiteLamp", **acquisition: Any) -> Path:
    """Write the pair of files that SPAS writes, of a spectrum that is red where a pattern is lit: 1 : 3 in two columns."""
    walsh = walsh_2d()[rows]
    lit = np.stack([walsh > 0, walsh < 0], axis=1).reshape(-1, SIZE * SIZE).astype(float)
    spectra = (lit @ IMAGE.ravel())[:, None] * [1.0, 3.0]
    np.savez_compressed(folder / f"{name}_spectraldata.npz", spectral_data=spectra)
    shown = [pattern for row in rows for pattern in (2 * row, 2 * row + 1)]
    people = {
        "pattern_prefix": "Walsh_8x8",
        "experiment_name": name,
        "object": "cat",
        "light_source": "white LED",
        "description": "two\tlines",
        "date": "22/04/2021",
        "class_description": "Metadata",
    }
    modulator = {"picture_time_us": 1344, "class_description": "DMD parameters"}
    parameters = {
        "pattern_dimension_x": SIZE,
        "pattern_dimension_y": SIZE,
        "patterns": str(shown),
        "wavelengths": "[500.0000, 650.5000]",
        "class_description": "Acquisition parameters",
        **acquisition,
    }
    path = folder / f"{name}_metadata.json"
    path.write_text(json.dumps([people, modulator, parameters], indent=4), encoding="utf8")
    return path


def test_a_whole_acquisition_by_spas_gives_the_image_and_what_people_said(tmp_path: Path) -> None:
    """All 64 patterns by their sign changes, down and across: the light is 4 times that of a lamp of one colour."""
    path = spas_pair(tmp_path, list(range(64)))
    done = convert(read_spas(path), tmp_path / "cat.h5")
    assert (done.frames, done.frames_measured) == (64, 64)
    np.testing.assert_allclose(image_of(done.path), 4 * IMAGE, atol=1e-9)
    info = recording_info(done.path)
    assert info.plan is not None
    assert (info.title, info.sample) == ("cat_whiteLamp", "cat")
    assert info.picture_time_s == pytest.approx(1344e-6)
    assert info.notes == "description: twolines\nlight_source: white LED\ndate: 22/04/2021"
    assert not info.photon_counts
    report, code = check_recording(done.path)
    assert code == 0
    assert {check.outcome for check in report.checks} == {"good", "warning"}
    assert not any("order of their own" in sentence for sentence in done.missing) or "tv" in str(info.plan.scheme)


def test_a_band_of_the_spectrum_is_one_of_its_columns(tmp_path: Path) -> None:
    spas_pair(tmp_path, list(range(64)))
    named = tmp_path / "cat_whiteLamp_spectraldata.npz"
    np.testing.assert_allclose(
        image_of(convert(read_spas(named, (600.0, 700.0)), tmp_path / "red.h5").path), 3 * IMAGE, atol=1e-9
    )
    np.testing.assert_allclose(read_spas(named, (500.0, 500.0)).values * 3, read_spas(named, (650.5, 650.5)).values)
    with pytest.raises(InputError, match=r"no wavelength from 700 to 800 nm; expected a band within 500 to 650.5 nm"):
        read_spas(named, (700.0, 800.0))


def test_patterns_in_an_order_of_their_own_are_put_in_ours_and_told(tmp_path: Path) -> None:
    """As a camera that shows the strongest half first: 32 of 64, the others masked; a pattern shown twice counts once."""
    rows = [0, *np.random.default_rng(5).permutation(np.arange(1, 64))[:31].tolist(), 0]
    done = convert(read_spas(spas_pair(tmp_path, rows)), tmp_path / "half.h5")
    assert done.frames_measured == 32
    assert "the patterns were shown in an order of their own: frames stand in the order tv, not in time" in done.missing
    assert f"{done.frames - 32} of {done.frames} frames were not measured, and are masked" in done.missing
    walsh = walsh_2d()[sorted(set(rows))]
    expected = (4 * walsh @ IMAGE.ravel()) @ walsh / 64
    np.testing.assert_allclose(image_of(done.path).ravel(), expected, atol=1e-9)
    assert np.isnan(open_recording(done.path).values[~open_recording(done.path).frame_valid]).all()


@pytest.mark.parametrize("order", ORDERS)
def test_a_vector_of_values_keeps_its_order(tmp_path: Path, order: HadamardOrder) -> None:
    """Of the first 37 patterns in an order of ours every frame is where it was shown."""
    np.savez(tmp_path / "values.npz", light=light_of(hadamard_order(SIZE, order)))
    found = read_array(tmp_path / "values.npz", None, order)
    first = replace(found, pairs=found.pairs[:37], values=found.values[:37])
    done = convert(first, tmp_path / "run.h5", picture_time_s=1e-4)
    assert (done.frames, done.frames_measured, len(done.missing)) == (37, 37, 1)
    np.testing.assert_allclose(open_recording(done.path).values.ravel(), light_of(found.pairs[:37]), atol=1e-9)


def test_differences_become_pairs_of_the_total_light(tmp_path: Path) -> None:
    """A coefficient d of a total T is (T + d) / 2 and (T - d) / 2; the picture time is not known, and told so."""
    light = light_of(hadamard_order(SIZE, "natural")).reshape(-1, 2)
    np.save(tmp_path / "run.npy", (light[:, 0] - light[:, 1]).astype(np.float32))
    done = convert(read_array(tmp_path / "run.npy", None, "natural"), tmp_path / "run.h5")
    recording = open_recording(done.path)
    np.testing.assert_allclose(recording.values, light, atol=1e-4)
    assert recording.picture_time_s == 1e-3
    assert "differences only" in done.missing[0]
    assert "1000 us stand for it" in done.missing[1]


def test_a_file_of_matlab_is_read_as_well(tmp_path: Path) -> None:
    """MATLAB has no vectors: a column of 128 values is one of 64 pairs."""
    scipy_io: Any = pytest.importorskip("scipy.io")
    light = light_of(hadamard_order(SIZE, "sequency"))
    scipy_io.savemat(tmp_path / "run.mat", {"light": light[:, None], "note": "by hand"})
    found = read_array(tmp_path / "run.mat", None, "sequency")
    np.testing.assert_allclose(found.values.ravel(), light)
    assert found.missing == ()


@pytest.mark.parametrize(
    ("arrays", "key", "order", "saw"),
    [
        ({"a": np.zeros(64), "b": np.zeros(64)}, None, "natural", r"several arrays .* a \(64,\), b \(64,\)"),
        ({"a": np.zeros(64)}, "c", "natural", "no array of that name"),
        ({"a": np.zeros((16, 16))}, None, "natural", r"a of shape \(16, 16\)"),
        ({"a": np.zeros(100)}, None, "natural", r"a of shape \(100,\)"),
        ({"a": np.zeros(129)}, None, "natural", r"a of shape \(129,\)"),
        ({"a": np.zeros(64)}, None, None, "without the order of its patterns"),
        ({"a": np.zeros(64)}, None, "random", "the order 'random'"),
        ({"a": np.array(["x"] * 64)}, None, "natural", "no array of numbers, but a"),
    ],
)
def test_what_says_too_little_is_refused(
    tmp_path: Path, arrays: dict[str, Any], key: str | None, order: str | None, saw: str
) -> None:
    np.savez(tmp_path / "x.npz", **arrays)
    with pytest.raises(InputError, match=saw):
        read_array(tmp_path / "x.npz", key, order)


def test_more_than_a_plan_can_ask_for_is_refused(tmp_path: Path) -> None:
    """The patterns of 512 x 512 px take 17 GB."""
    np.save(tmp_path / "large.npy", np.zeros(512 * 512, np.float32))
    with pytest.raises(InputError, match="262144 patterns of 512 x 512 px"):
        convert(read_array(tmp_path / "large.npy", None, "natural"), tmp_path / "large.h5")


def test_nothing_in_a_file_is_carried_out(tmp_path: Path) -> None:
    """A pickled object is no array of numbers; nor is text, a cut file, or another kind of file."""
    np.savez(tmp_path / "object.npz", a=np.array([{}], dtype=object))
    (tmp_path / "text.npz").write_text("PK no")
    whole = tmp_path / "whole.npz"
    np.savez(whole, a=np.zeros(64))
    (tmp_path / "cut.npz").write_bytes(whole.read_bytes()[:100])
    (tmp_path / "run.csv").write_text("1,2")
    (tmp_path / "text.mat").write_text("no")
    for name in ("object.npz", "text.npz", "cut.npz", "run.csv", "none.npz", "text.mat"):
        with pytest.raises(InputError, match=name):
            read_array(tmp_path / name, None, "natural")


@pytest.mark.parametrize(
    ("changed", "saw"),
    [
        ({"patterns": "[0, 1, 2]"}, "spectral_data of shape"),
        ({"patterns": str([*range(1, 128), 0])}, "no pairs"),
        ({"patterns": str([*range(126), 128, 129])}, "pattern 129"),
        ({"pattern_dimension_y": 16}, "8 x 16 px"),
        ({"pattern_dimension_x": 12, "pattern_dimension_y": 12}, "12 x 12 px"),
        ({"mask_index": [1, 2]}, "a mask"),
    ],
)
def test_a_pair_that_does_not_belong_together_or_shows_other_patterns_is_refused(
    tmp_path: Path, changed: dict[str, Any], saw: str
) -> None:
    with pytest.raises(InputError, match=saw):
        read_spas(spas_pair(tmp_path, list(range(64)), **changed))


def test_long_words_are_cut_where_a_table_has_no_more_room(tmp_path: Path) -> None:
    path = spas_pair(tmp_path, list(range(64)))
    tables = json.loads(path.read_text())
    tables[0] |= {"object": "o" * 300, "experiment_name": "", "filter": "f" * 2000}
    path.write_text(json.dumps(tables))
    about = read_spas(path).about
    assert (about.sample, about.title) == ("o" * 200, "cat_whiteLamp")
    assert f"filter: {'f' * 1000}\n" in about.notes


def test_half_a_pair_is_refused_by_the_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = spas_pair(tmp_path, list(range(64)))
    path.write_text("{}")
    assert status(["convert", str(path)]) == 2
    assert "no list of tables" in capsys.readouterr().err
    path.unlink()
    assert status(["convert", str(tmp_path / "cat_whiteLamp_spectraldata.npz")]) == 2
    assert "cat_whiteLamp_metadata.json" in capsys.readouterr().err


def test_the_command_names_the_recording_and_says_what_is_missing(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = spas_pair(tmp_path, list(range(64)))
    assert status(["convert", str(path), "--json", "--picture-time-us", "500"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert (told["path"], told["frames"]) == (str(tmp_path / "cat_whiteLamp.h5"), 64)
    assert told["missing"] == told["warnings"]
    assert open_recording(told["path"]).picture_time_s == 500e-6
    assert status(["convert", str(path)]) == 2, "it exists"
    assert status(["convert", str(path), "--picture-time-us", "0"]) == 2


DENBO, SPIRIT = MEASURED / "denbo", MEASURED / "spirit"


@pytest.mark.skipif(not DENBO.is_dir(), reason="measured data not there: set KINOPIX_DATA")
def test_a_measured_vector_becomes_a_recording_that_gives_the_published_picture(tmp_path: Path) -> None:
    done = convert(read_array(DENBO / "denbo_errors_car_vectors.npz", "boat_roi017", "natural"), tmp_path / "boat.h5")
    with Image.open(DENBO / "boat_8.5.png") as file:
        published = np.asarray(file.convert("L"), np.float64)[6::12, 6::12]
    assert np.corrcoef(image_of(done.path).ravel(), published.ravel())[0, 1] >= 0.999
    assert check_recording(done.path)[1] == 0


@pytest.mark.skipif(not SPIRIT.is_dir(), reason="measured data not there: set KINOPIX_DATA")
def test_measured_wavelets_are_refused_with_the_reason() -> None:
    with pytest.raises(InputError, match="such as wavelets, have no scheme here"):
        read_array(SPIRIT / "Jaszczak_Haar_4_128x128.mat", "W", "natural")
