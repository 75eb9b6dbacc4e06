"""The light of the field, block by block."""

from pathlib import Path

import numpy as np
import pytest

from instrument.calibration import PictureField, calibrate_light, falloff_of
from protocols import InputError
from tests.instrument.calibration.benches import bench_of


def test_falloff_and_background(tmp_path: Path) -> None:
    """Corners of a block lie at (7/8)^2 + 1/192 of the square of the half side: the fit takes its mean."""
    scene = {"illumination_falloff": 0.35, "ambient_level": 0.02}
    with bench_of(scene, dead_time_s=2e-8, dark_rate_hz=600.0) as bench:
        found = calibrate_light(bench, PictureField(tmp_path, 32, 4), seconds=1.5)
    section = found.section
    assert section.falloff.value == pytest.approx(0.35, abs=4 * section.falloff.sigma)
    assert section.falloff.sigma < 0.05
    assert section.background_hz.value == pytest.approx(100_600, abs=4 * section.background_hz.sigma)
    assert section.white_hz == pytest.approx(5e6 * (1 - 0.35 / 3), rel=0.15)
    profile, sigma = np.array(section.profile), np.array(section.profile_sigma)
    assert profile.mean() == pytest.approx(1.0, abs=1e-4)
    place = (np.arange(8) + 0.5) / 4 - 1
    square = (place[:, None] ** 2 + place**2) / 2
    expected = (1 - 0.35 * square) / np.mean(1 - 0.35 * square)
    assert np.std((profile - expected) / sigma) == pytest.approx(1.0, abs=0.35)
    assert section.field_mirrors == 128
    assert found.doubts == ()


def test_an_object_in_the_light_is_doubted(tmp_path: Path) -> None:
    with bench_of({"object_height_px": 8, "start_px": [8, 8]}) as bench:
        found = calibrate_light(bench, PictureField(tmp_path, 32, 4), seconds=0.5)
    assert "take the object out of the light" in found.doubts[0]
    brightest = np.unravel_index(np.argmax(found.section.profile), (8, 8))
    assert {int(place) for place in brightest} <= {1, 2}


def test_stray_light_is_doubted_and_no_light_refused(tmp_path: Path) -> None:
    with bench_of({"ambient_level": 0.5}) as bench:
        assert (
            "look for stray light" in calibrate_light(bench, PictureField(tmp_path / "a", 32, 4), seconds=0.5).doubts[0]
        )
    with bench_of({"object_level": 0.0}, dark_rate_hz=600.0) as bench, pytest.raises(InputError, match="lamp on"):
        calibrate_light(bench, PictureField(tmp_path / "b", 32, 4), seconds=0.2)


@pytest.mark.parametrize("falloff", [0.0, 0.35, 0.9])
def test_the_fit_is_exact_on_exact_light(falloff: float) -> None:
    """Mean of (r / corner)^2 over blocks of 1000 x 1000 points."""
    fine = (np.arange(8000) + 0.5) / 4000 - 1
    squares = (fine**2).reshape(8, 1000).mean(axis=1)
    profile = 3 * (1 - falloff * (squares[:, None] + squares) / 2)
    found = falloff_of(profile, np.full((8, 8), 0.1))
    assert found.value == pytest.approx(falloff, abs=1e-5)
