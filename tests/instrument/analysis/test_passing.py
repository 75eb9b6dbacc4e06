"""An object wider than the field passes by on a calibrated stage: its path, and an image that reaches outside the field."""

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from instrument import Instrument, Plan, Recording, analyse
from instrument.analysis import Analysis, compare, forming, store
from instrument.analysis.passing import stage_path
from instrument.measurement import Measurement
from instrument.numerics import psnr
from instrument.plan import MotionPlan
from instrument.storage import open_recording, stored_analysis
from instrument.views.film import write_film
from instrument.views.summary import summary_figure
from protocols import Floats, InputError
from sim_backends.bench.objects import BUILT_INS
from tests.support.plain_hdf5 import array

SIZE, WIDE = 32, 44
MOTION = MotionPlan(velocity_mm_s=40 / 20 / 0.15, acceleration_mm_s2=200.0, field="may-leave")
PLAN = Plan(frames=500, image_size=SIZE, motion=MOTION)


def _object() -> Floats:
    """A ring, a bar and a T, 16 x 44 px."""
    cells = np.zeros((16, WIDE))
    cells[:, :16] = BUILT_INS["ring"](16).cells
    cells[:, 20:24] = 1
    letter = BUILT_INS["letter-T"](16).cells
    cells[:, 28 : 28 + letter.shape[1]] = letter
    return cells


BENCH = """
calibration = "calibration.toml"
[modulator]
driver = "simulated"
[counter]
driver = "simulated"
[stage]
driver = "simulated"
[scene]
object = "object.npy"
object_height_px = 16.0
start_px = [-2.0, 16.0]
px_per_mm = 20.0
axis_angle_deg = 0.0
noise = { kind = "pixel", sigma = 0.05, seed = 1 }
"""

CALIBRATION = """
version = 1
[bench]
[displacement]
px_per_mm_x = 20.4
px_per_mm_y = 0.0
image_size = 32
superpixel = 2
date = 2026-01-01T00:00:00Z
"""
"""2 % more than the scene has."""


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """At the start the object reaches from column -24 to 20, at the end from 16 to 60, of a field of 32."""
    folder = tmp_path_factory.mktemp("wide")
    np.save(folder / "object.npy", _object())
    (folder / "bench.toml").write_text(BENCH)
    (folder / "calibration.toml").write_text(CALIBRATION)
    with Instrument.from_toml(folder / "bench.toml") as bench:
        bench.run(PLAN, folder / "run.h5")
    return folder / "run.h5"


@pytest.fixture(scope="module")
def passing(file: Path) -> Recording:
    return open_recording(file)


@pytest.fixture(scope="module")
def found(passing: Recording) -> Analysis:
    return analyse(passing, region="wide", grid="1")


def test_the_path_is_corrected_from_a_calibration_that_is_off_by_2_percent(passing: Recording, found: Analysis) -> None:
    assert passing.truth is not None
    assert found.trajectory is not None
    error_px = found.trajectory.displacement_px - passing.truth.displacement_px
    assert np.abs(error_px).max() < 0.5  # 0.8 at the start of the refinement
    assert (np.abs(error_px[1:]) < 3 * found.trajectory.sigma_px[1:]).all()
    assert found.trajectory.start_px is None


def test_the_image_reaches_outside_the_field_and_says_where_it_is(found: Analysis) -> None:
    assert found.reconstruction is not None
    figures, image = found.figures, found.reconstruction.at_patterns
    assert figures.image_px == image.shape[::-1]
    assert figures.origin_px is not None
    x, y = figures.origin_px
    assert 40 <= x <= 42
    true = np.zeros_like(image)
    true[y + 8 : y + 24, x - 24 : x + 20] = _object()
    assert psnr(image[:, x - 14 :], true[:, x - 14 :]) > 20
    assert f"the field begins at column {x}, row {y} of it" in figures.rows()["image"]
    assert any("passes by" in text for text in figures.found)
    assert not [text for text in figures.doubts if "border to border" in text or "total light changed" in text]


def test_file_and_pictures_hold_the_wide_image(file: Path, passing: Recording, found: Analysis, tmp_path: Path) -> None:
    assert found.reconstruction is not None
    store(file, passing, found, tmp_path / "copy.h5")
    read = stored_analysis(tmp_path / "copy.h5")
    assert read is not None
    assert read.image is not None
    np.testing.assert_array_equal(read.image, found.reconstruction.image)
    assert read.origin_px == found.figures.origin_px
    x_px, y_px = (array(tmp_path / "copy.h5", f"entry/analysis/image/{name}") for name in ("x_px", "y_px"))
    assert (x_px[read.origin_px[0]], y_px[read.origin_px[1]]) == (0, 0)
    assert (len(y_px), len(x_px)) == read.image.shape
    axes = summary_figure(found).axes[1]
    assert axes.get_xlim() == (x_px[0] - 0.5, x_px[-1] + 0.5)
    border = next(line for line in axes.get_lines() if "field" in str(line.get_label()))
    assert np.ptp(border.get_xydata(), axis=0).tolist() == [SIZE, SIZE]


def test_a_film_shows_the_field_and_beside_it_the_wide_image(found: Analysis, tmp_path: Path) -> None:
    stages = list(forming(found, 2))
    assert found.image is not None
    assert {stage.image.shape for stage in stages} == {found.image.shape}
    film = write_film(found, tmp_path / "film.gif", pictures=2)
    assert film.stat().st_size > 1000


@pytest.mark.thorough
def test_it_is_compared_by_what_is_in_the_field(passing: Recording) -> None:
    assert compare(passing, passing).figures.shift_px == pytest.approx((0.0, 0.0), abs=0.1)


def test_the_stage_tells_the_path_where_it_is_calibrated(passing: Recording) -> None:
    """40 px at 20 px/mm, told with 20.4 px/mm: 40.8 px, from the middle of the first frame to that of the last."""
    told = stage_path(passing, Measurement.of(passing))
    assert told is not None
    assert told.displacement_px[-1] == pytest.approx([40.8 * 499 / 500, 0], abs=0.1)
    assert stage_path(replace(passing, calibration=None), Measurement.of(passing)) is None


def test_without_a_calibration_no_uncertainty_is_stated(passing: Recording) -> None:
    found = analyse(replace(passing, calibration=None).first(64), region="wide", grid="1")
    assert found.figures.sigma_px is None
    assert found.figures.motion_px is None
    assert any("begun from the phases" in text for text in found.figures.doubts)


@pytest.mark.thorough
def test_a_calibration_that_is_far_off_is_told(passing: Recording) -> None:
    """By 40 %, 16 px, of which refining pulls in a part."""
    assert passing.calibration is not None
    assert passing.calibration.displacement is not None
    far = passing.calibration.displacement.model_copy(update={"px_per_mm_x": 28.0})
    calibration = passing.calibration.model_copy(update={"displacement": far})
    found = analyse(replace(passing, calibration=calibration), region="wide", grid="1")
    assert found.figures.sigma_px is None
    assert any("no uncertainty is stated" in text for text in found.figures.doubts)


@pytest.mark.thorough
def test_an_object_that_passes_by_is_found_out(passing: Recording) -> None:
    found = analyse(passing, grid="1")
    assert found.figures.image_px is not None
    assert any("passes by" in text for text in found.figures.found)


@pytest.mark.parametrize(
    "wrong",
    [{"tracking": "smooth"}, {"method": "dgi"}, {"shape": "changing"}, {"normalise": "frame"}],
    ids=["tracking", "method", "shape", "normalise"],
)
def test_methods_that_see_no_object_pass_by_are_refused(passing: Recording, wrong: dict[str, Any]) -> None:
    with pytest.raises(InputError, match="region wide"):
        analyse(passing, region="wide", **wrong)


def test_an_unknown_region_is_refused(passing: Recording) -> None:
    with pytest.raises(InputError, match="the region 'outside'"):
        analyse(passing, region="outside")  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]
