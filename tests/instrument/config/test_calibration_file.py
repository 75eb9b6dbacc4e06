"""A calibration file: written, read again, mended section by section, refused where it does not belong."""

import math
import tomllib
from datetime import UTC, datetime
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st
from pydantic import ValidationError

from instrument.config import (
    Calibration,
    CalibrationPosition,
    ConfigError,
    DetectorSection,
    DisplacementSection,
    Measured,
    load_bench,
    read_calibration,
    updated_calibration,
    write_calibration,
)
from protocols import DeviceIdentity, InputError
from tests.support.benches import bench_toml
from tests.support.calibrations import DATE, SIMULATED, calibrated_bench_toml, calibration, displacement

WHOLE = DisplacementSection(
    date=DATE,
    image_size=128,
    superpixel=2,
    px_per_mm_x=4.0,
    px_per_mm_y=-3.0,
    covariance=((4e-4, 1e-4), (1e-4, 9e-4)),
    degrees_of_freedom=4,
    method="static images",
    rms_residual_px=0.012,
    backlash_mm=-0.02,
    backlash_sigma_mm=0.003,
    object_at_mm=5.0,
    object_box_px=(10.0, 12.0, 40.5, 50.25),
    positions=(
        CalibrationPosition(
            stage_mm=1.5,
            approach="upward",
            shift_px=(0.0, 0.0),
            sigma_px=(0.01, 0.02),
            residual_px=(0.001, -0.002),
        ),
    ),
)

DETECTOR = DetectorSection(date=DATE, dark_rate_hz=Measured(value=600.0, sigma=2.5))


def identities(**serials: str) -> dict[str, DeviceIdentity]:
    """The simulated devices, with serial numbers."""
    return {
        role: DeviceIdentity(name=role, vendor=device.vendor, model=device.model, serial=serials.get(role, ""))
        for role, device in SIMULATED.items()
    }


def test_scale_and_axis_follow_from_both_components() -> None:
    """4 to the right and 3 up: 5 px/mm; the variance along the axis is 0.64 xx - 0.96 xy + 0.36 yy."""
    assert WHOLE.px_per_mm == 5.0
    assert WHOLE.axis == (0.8, -0.6)
    assert WHOLE.axis_angle_deg == pytest.approx(-36.8699, abs=1e-4)
    assert WHOLE.px_per_mm_sigma == pytest.approx(math.sqrt(0.64 * 4e-4 - 0.96 * 1e-4 + 0.36 * 9e-4), rel=1e-12)
    across = math.sqrt(0.36 * 4e-4 + 0.96 * 1e-4 + 0.64 * 9e-4)
    assert WHOLE.axis_angle_sigma_deg == pytest.approx(math.degrees(across / 5), rel=1e-12)


def test_what_is_written_is_read(tmp_path: Path) -> None:
    whole = calibration(WHOLE).model_copy(update={"magnification": "relay 1:1", "detector": DETECTOR})
    write_calibration(tmp_path / "c.toml", whole)
    assert read_calibration(tmp_path / "c.toml") == whole
    assert tomllib.loads((tmp_path / "c.toml").read_text())["displacement"]["date"] == DATE
    assert [path.name for path in tmp_path.iterdir()] == ["c.toml"]


@given(
    x=st.floats(-1e3, 1e3).filter(lambda v: abs(v) > 1e-3),
    y=st.floats(-1e3, 1e3),
    day=st.datetimes(datetime(1990, 1, 1), datetime(2100, 1, 1), timezones=st.just(UTC)),  # noqa: DTZ001 - the zone is given beside
)
def test_every_number_comes_back_to_the_last_bit(
    tmp_path_factory: pytest.TempPathFactory, x: float, y: float, day: datetime
) -> None:
    path = tmp_path_factory.getbasetemp() / "c.toml"
    section = displacement().model_copy(update={"px_per_mm_x": x, "px_per_mm_y": y, "date": day})
    write_calibration(path, calibration(section))
    assert read_calibration(path).displacement == section


def test_a_section_measured_anew_keeps_the_others(tmp_path: Path) -> None:
    path = tmp_path / "c.toml"
    updated_calibration(path, "detector", DETECTOR, identities())
    updated_calibration(path, "displacement", WHOLE, identities())
    later = displacement(9.0)
    assert updated_calibration(path, "displacement", later, identities()) == read_calibration(path)
    assert read_calibration(path).sections == {"displacement": later, "detector": DETECTOR}


@pytest.mark.parametrize(
    ("old", "new", "same"), [("1", "2", False), ("", "2", True), ("1", "", True), ("1", "1", True)]
)
def test_serial_numbers_tell_devices_apart_where_both_are_known(tmp_path: Path, old: str, new: str, same: bool) -> None:  # noqa: FBT001 - a parameter of the table
    path = tmp_path / "c.toml"
    updated_calibration(path, "displacement", WHOLE, identities(stage=old))
    if same:
        updated_calibration(path, "displacement", displacement(), identities(stage=new))
        return
    with pytest.raises(InputError, match=r"stage: saw .* simulated KA400Z 1; expected one made with .* KA400Z 2"):
        updated_calibration(path, "displacement", displacement(), identities(stage=new))
    assert read_calibration(path).displacement == WHOLE


def test_other_optics_are_refused_by_name() -> None:
    here = Calibration(magnification="relay 1:1", bench=SIMULATED)
    here.refuse_other_bench(identities(), "relay 1:1")
    with pytest.raises(InputError, match=r"at the magnification 'relay 1:1'; expected one at 'relay 2:1'"):
        here.refuse_other_bench(identities(), "relay 2:1")


@pytest.mark.parametrize(("image_size", "superpixel"), [(256, 2), (128, 1), (64, 4)])
def test_other_pixels_are_refused_by_name(image_size: int, superpixel: int) -> None:
    known = calibration(WHOLE)
    known.refuse_other_grid(128, 2)
    with pytest.raises(InputError, match=rf"{image_size} px of {superpixel} x {superpixel} mirrors, where \[displ"):
        known.refuse_other_grid(image_size, superpixel)
    Calibration(bench=SIMULATED, detector=DETECTOR).refuse_other_grid(image_size, superpixel)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("version = 2\n", "c.toml:1: version: saw version 2; expected 1, which this program reads (install a newer"),
        ("version = true\n", "version: saw version True"),
        ("frames = 3\n", "version: saw no version; expected 1"),
        ("version = 1\n[bench]\n[displacment]\n", "c.toml:3: displacment: saw an unknown key"),
        ("version = 1\n[bench]\n[detector]\ndate = 2023-04-01T12:30:00\n", "detector.date: saw"),
    ],
)
def test_what_is_no_calibration_is_refused_with_its_line(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "c.toml").write_text(text)
    with pytest.raises(ConfigError) as caught:
        read_calibration(tmp_path / "c.toml")
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("wrong", "message"),
    [
        ({"px_per_mm_x": 0.0, "px_per_mm_y": 0.0}, "make 0 px/mm"),
        ({"covariance": ((1.0, 2.0), (2.0, 1.0))}, "covariance is no covariance"),
        ({"covariance": ((1.0, 0.5), (0.0, 1.0))}, "covariance is no covariance"),
        ({"covariance": ((-1.0, 0.0), (0.0, -1.0))}, "covariance is no covariance"),
        ({"object_at_mm": None}, "belong together"),
        ({"object_box_px": (5.0, 1.0, 5.0, 2.0)}, "left, top, right, bottom"),
        ({"object_box_px": (1.0, 5.0, 2.0, 4.0)}, "left, top, right, bottom"),
    ],
)
def test_numbers_that_contradict_each_other_are_refused(wrong: dict[str, object], message: str) -> None:
    with pytest.raises(ValidationError, match=message):
        DisplacementSection.model_validate({**WHOLE.model_dump(), **wrong})


def test_bench_toml_names_it_relative_to_itself(tmp_path: Path) -> None:
    bench = load_bench(calibrated_bench_toml(tmp_path, WHOLE))
    assert bench.calibration == calibration(WHOLE)
    assert bench.calibration_path == tmp_path / "mine.toml"


def test_a_bench_that_is_to_be_calibrated_needs_no_file_yet(tmp_path: Path) -> None:
    path = bench_toml(tmp_path)
    path.write_text('magnification = "f = 100 mm"\ncalibration = "none.toml"\n' + path.read_text())
    bench = load_bench(path, calibrated=False)
    assert (bench.calibration, bench.calibration_path) == (None, tmp_path / "none.toml")
    assert bench.magnification == "f = 100 mm"
    with pytest.raises(ConfigError, match=r"none\.toml: saw no such file"):
        load_bench(path)


def test_a_folder_that_cannot_be_written_is_said(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="cannot be written to"):
        write_calibration(tmp_path / "none" / "c.toml", calibration())
