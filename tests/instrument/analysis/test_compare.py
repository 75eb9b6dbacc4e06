"""Two images held against each other: numbers by hand, and a moving run against a reference image at rest."""

import json
from pathlib import Path

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from instrument.analysis.compare import compare_images, edge_width_px
from instrument.calibration import static_plan
from instrument.cli.main import status
from instrument.plan import MotionPlan, Plan
from instrument.session import Instrument
from protocols import Floats, InputError
from tests.support.benches import bench_toml


def square(size: int = 48, blur_px: float = 1.5) -> Floats:
    """A bright square in the middle."""
    image = np.zeros((size, size))
    image[16:32, 14:30] = 1.0
    return np.asarray(gaussian_filter(image, blur_px), np.float64)


def test_an_image_is_moved_and_scaled_onto_the_reference() -> None:
    there = square()
    image = 0.25 * np.roll(there, (3, -5), axis=(0, 1))
    found = compare_images(there, image)
    np.testing.assert_allclose(found.figures.shift_px, (5.0, -3.0), atol=1e-3)
    assert found.figures.psnr_db > 60
    assert found.figures.ssim_global == pytest.approx(1.0, abs=1e-4)
    assert found.figures.edge_width_px == pytest.approx(found.figures.reference_edge_width_px, rel=1e-3)


def test_noise_lowers_the_psnr_to_what_it_must() -> None:
    """Noise of 0.05 on bright pixels alone would be 26 dB; on dark ones the half below 0 is cut off."""
    there = square()
    noisy = there + 0.05 * np.random.default_rng(1).standard_normal(there.shape)
    assert 26 < compare_images(there, noisy).figures.psnr_db < 30


@pytest.mark.parametrize("width_px", [4, 8])
def test_the_edge_of_a_ramp_is_0_8_of_its_width(width_px: int) -> None:
    ramp = np.clip((np.arange(64) - 20) / width_px, 0, 1) * np.ones((64, 1))
    assert edge_width_px(np.asarray(ramp, np.float64)) == pytest.approx(0.8 * width_px, rel=1e-6)


def test_a_blurred_edge_is_wider_by_its_blur() -> None:
    """From 10 to 90 % a Gaussian edge is 2.56 sigma wide; at its steepest it is 0.8 sqrt(2 pi) = 2.01 sigma by this measure."""
    assert edge_width_px(square(blur_px=2.5)) == pytest.approx(2.01 * 2.5, rel=0.15)


def test_a_dark_image_is_refused() -> None:
    with pytest.raises(InputError, match="an image without light"):
        compare_images(square(), np.zeros((48, 48)))


def test_a_run_in_motion_is_compared_with_the_object_at_rest(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """From recording to figures and picture, as its user would."""
    noise = 'noise = { kind = "poisson", peak_counts = 2000, seed = 1 }\nstart_px = [12.4, 12.7]\nblur_px = 0.5'
    with Instrument.from_toml(bench_toml(tmp_path, noise)) as bench:
        motion = MotionPlan(velocity_mm_s=25)
        bench.run(Plan(frames=500, image_size=32, superpixel=4, motion=motion), tmp_path / "run.h5")
        bench.stage.move_to(10.0, motion.profile).wait()
        bench.run(static_plan(32, 4, frames=1024), tmp_path / "still.h5")
    files = [str(tmp_path / "still.h5"), str(tmp_path / "run.h5")]
    assert status(["compare", *files, "--json", "--picture", str(tmp_path / "both.png")]) == 0
    found = json.loads(capsys.readouterr().out)
    assert found["psnr_db"] > 25
    assert found["ssim_global"] > 0.95
    assert np.abs(found["shift_px"]).max() < 13
    assert 1.0 < found["edge_width_px"] < 1.3 * found["reference_edge_width_px"]
    assert (tmp_path / "both.png").stat().st_size > 10_000
    assert status(["compare", *files]) == 0
    assert "edge width" in capsys.readouterr().out


def test_other_pixels_cannot_be_compared(tmp_path: Path) -> None:
    with Instrument.from_toml(bench_toml(tmp_path)) as bench:
        for size in (16, 32):
            bench.run(static_plan(size, 4, frames=64), tmp_path / f"{size}.h5")
    assert status(["compare", str(tmp_path / "16.h5"), str(tmp_path / "32.h5")]) == 2
