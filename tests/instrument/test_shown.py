"""Values at a prompt, in a notebook, and as tables of pandas and xarray."""

import re
import sys
from base64 import b64decode
from html.parser import HTMLParser
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from PIL import Image

from instrument.analysis import Analysis, analyse
from instrument.measurement import Measurement
from instrument.plan import MotionPlan, Plan
from instrument.recording import Recording
from instrument.session import Instrument
from instrument.shown import card, curves, grey, line
from protocols import Floats, InputError
from tests.support.benches import SMALL, bench_toml
from tests.support.calibrations import calibrated_bench_toml, displacement
from tests.support.objects import letter
from tests.support.plans import plan_of
from tests.support.simulation import simulate


@pytest.fixture(scope="module")
def analysis() -> Analysis:
    """20 frames of a letter that goes 6 px right and down."""

    def path(time_s: Floats) -> Floats:
        return np.stack([8.0 + time_s / 1e-3] * 2, axis=1)

    recording = simulate(plan_of("fourier-hadamard", 20, 32), letter(32, "letter-B", 12), path, sigma=0.02, seed=1)
    return analyse(recording, tracking="smooth", method="conventional")


def html_of(value: Any) -> str:
    """As a notebook asks for it."""
    html: str = value._repr_html_()
    return html


class Checked(HTMLParser):
    """Makes sure that every element that is opened is closed."""

    def __init__(self, html: str) -> None:
        super().__init__()
        self.open: list[str] = []
        self.seen: list[str] = []
        self.feed(html)
        self.close()
        assert self.open == []

    def handle_starttag(self, tag: str, attrs: object) -> None:
        self.seen.append(tag)
        if tag != "img":
            self.open.append(tag)

    def handle_startendtag(self, tag: str, attrs: object) -> None:
        self.seen.append(tag)

    def handle_endtag(self, tag: str) -> None:
        assert self.open.pop() == tag


def test_each_value_is_one_short_line(analysis: Analysis, tmp_path: Path) -> None:
    assert repr(analysis.recording) == (
        "<Recording: 20 of 20 frames, fourier-hadamard, 32 x 32 px, 20000 patterns/s, at rest>"
    )
    assert re.fullmatch(
        r"<Trajectory: 20 frames in 0\.006 s, to x \+\d\.\d\d, y \+\d\.\d\d px, known to 0\.\d{3} px \(median\), smooth>",
        repr(analysis.trajectory),
    )
    assert re.fullmatch(
        r"<Reconstruction: 32 x 32 px, conventional, misfit .* \(1 is the noise alone\)>", repr(analysis.reconstruction)
    )
    assert re.fullmatch(
        r"<Analysis: 20 frames, displacement MSE .*, image PSNR .* dB, tracking smooth.*>", repr(analysis)
    )
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        assert repr(bench) == (
            "<Instrument: Kinopix simulated DLP7000, Kinopix simulated H10682 and counter, Kinopix simulated KA400Z, at rest>"
        )
        assert re.fullmatch(r"<CheckReport: \d+ checks, all good>", repr(bench.check(SMALL)))
        too_fast = SMALL.model_copy(update={"pattern_rate_hz": 40_000.0})
        assert re.fullmatch(r"<CheckReport: \d+ checks, 1 error>", repr(bench.check(too_fast)))


def test_a_recording_says_what_is_masked_how_it_was_timed_and_where_it_is(tmp_path: Path) -> None:
    with Instrument.from_toml(bench_toml(tmp_path, counter="edge_times = true")) as bench:
        recording = bench.run(SMALL, tmp_path / "run.h5")
    assert repr(recording).endswith("25 mm/s, timing good, run.h5>")
    masked = Recording(recording.plan, recording.values, np.arange(40) > 2, recording.picture_time_s)
    assert "40 of 40 frames, 3 masked" in repr(masked)


def test_each_value_is_a_card_in_a_notebook(analysis: Analysis, tmp_path: Path) -> None:
    values: list[Any] = [analysis, analysis.recording, analysis.trajectory, analysis.reconstruction, SMALL]
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        values += [bench, bench.check(SMALL)]
        cards = [Checked(html_of(value)) for value in values]
    assert [("img" in found.seen, "svg" in found.seen) for found in cards] == [
        (True, True),
        (False, True),
        (False, True),
        (True, False),
        (False, False),
        (False, False),
        (False, False),
    ]
    assert all(len(html_of(value)) < 30_000 for value in values)


def test_a_plan_says_what_follows_from_it() -> None:
    plan = Plan(
        frames=1000, motion=MotionPlan(start_mm=1.0, velocity_mm_s=10.0, acceleration_mm_s2=100.0, settle_s=0.0)
    )
    html = html_of(plan)
    for words in ("6000 patterns in 0.3 s", "3333 frames/s", "10 mm/s from 1 to 5 mm"):
        assert words in html
    assert "at rest" in html_of(Plan(frames=1))


def test_an_empty_recording_and_a_path_of_which_nothing_is_known_are_shown_too(analysis: Analysis) -> None:
    plan = SMALL
    empty = Recording(plan, np.zeros((0, 6)), np.zeros(0, np.bool_), 50e-6)
    Checked(html_of(empty))
    assert repr(empty).startswith("<Recording: 0 of 40 frames")
    assert Measurement.of(analysis.recording) is not None


def test_what_is_shown_is_shown_and_not_obeyed() -> None:
    html = card("<b>", {"<script>": "a & b"}, "")
    assert "&lt;b&gt;" in html
    assert "&lt;script&gt;" in html
    assert "a &amp; b" in html
    assert line("Thing", "", "a", "") == "<Thing: a>"


def test_an_image_is_a_grey_picture_of_its_own_size() -> None:
    html = grey(np.array([[0.0, 1.0], [np.nan, 2.0], [-1.0, 0.5]]), 'the "image"')
    assert 'alt="the &quot;image&quot;"' in html
    (data,) = re.findall(r"base64,([^\"]+)", html)
    with Image.open(BytesIO(b64decode(data))) as picture:
        assert np.asarray(picture).tolist() == [[0, 128], [0, 255], [0, 64]]
    (data,) = re.findall(r"base64,([^\"]+)", grey(np.array([[0.25, 0.5]]), "dim"))
    with Image.open(BytesIO(b64decode(data))) as picture:
        assert np.asarray(picture).tolist() == [[128, 255]]


def test_curves_go_from_the_lowest_to_the_highest_value_with_bands() -> None:
    time_s = np.array([0.0, 1.0, 2.0])
    values = np.array([[0.0, 0.0], [5.0, np.nan], [10.0, -10.0]])
    sigma = np.array([[0.0, 0.0], [1.0, 1.0], [np.inf, 1.0]])
    svg = curves(time_s, values, sigma, "path", "px")
    x_line, y_line = re.findall(r'<polyline points="([^"]+)"', svg)
    assert x_line == "46.0,65.0 228.0,37.5 410.0,10.0"
    assert y_line == "46.0,65.0 410.0,120.0"
    x_band, _ = re.findall(r'<polygon points="([^"]+)"', svg)
    assert x_band == "46.0,65.0 228.0,48.5 228.0,26.5 46.0,65.0"
    assert curves(time_s, np.full((3, 1), np.nan), None, "path", "px") == ""
    assert len(curves(np.arange(9999.0), np.zeros((9999, 2)), None, "path", "px")) < 10_000


def test_a_path_is_a_data_frame(analysis: Analysis) -> None:
    pandas = pytest.importorskip("pandas")
    path = analysis.trajectory
    assert path is not None
    frame = path.to_dataframe()
    assert isinstance(frame, pandas.DataFrame)
    assert list(frame.columns) == ["time_s", "x_px", "y_px", "sigma_x_px", "sigma_y_px", "measured"]
    assert frame.index.name == "frame"
    assert frame["y_px"].to_numpy().tolist() == path.displacement_px[:, 1].tolist()
    assert frame["time_s"][1] == pytest.approx(4.5e-4)


def test_a_path_of_a_calibrated_bench_has_millimetres(tmp_path: Path) -> None:
    pytest.importorskip("pandas")
    section = displacement(2.0, 0.0, image_size=32, superpixel=4)
    with Instrument.from_toml(calibrated_bench_toml(tmp_path, section, 'object = "letter-B"')) as bench:
        recording = bench.run(SMALL, tmp_path / "run.h5")
        assert "calibration" in html_of(bench)
    path = analyse(recording, tracking="per-frame", method="conventional").trajectory
    assert path is not None
    frame = path.to_dataframe()
    assert frame["along_mm"].to_numpy() == pytest.approx(path.displacement_px[:, 0] / 2)
    assert "2 px/mm" in repr(path)


def test_recording_and_image_are_data_sets(analysis: Analysis) -> None:
    xarray = pytest.importorskip("xarray")
    recorded = analysis.recording.to_xarray()
    assert isinstance(recorded, xarray.Dataset)
    assert dict(recorded.sizes) == {"frame": 20, "pattern": 6}
    assert recorded["values"].to_numpy().tolist() == analysis.recording.values.tolist()
    assert float(recorded["pattern_time_s"][1, 2]) == pytest.approx(8.5 * 50e-6)
    assert recorded["time_s"].attrs["units"] == "s"
    assert analysis.reconstruction is not None
    image = analysis.reconstruction.to_xarray()
    assert image["image"].dims == ("y_px", "x_px")
    assert image["x_px"].to_numpy()[:2].tolist() == [0.0, 1.0]


@pytest.mark.parametrize("library", ["pandas", "xarray"])
def test_without_the_library_it_says_how_to_get_it(
    library: str, analysis: Analysis, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, library, None)
    assert analysis.trajectory is not None
    asked = analysis.trajectory.to_dataframe if library == "pandas" else analysis.recording.to_xarray
    with pytest.raises(InputError, match=f"pip install {library}"):
        asked()
