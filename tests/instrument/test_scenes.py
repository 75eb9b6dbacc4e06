"""Objects that nobody drew for this program, on motions that nothing was tuned for."""

from pathlib import Path

import numpy as np
import pytest
from PIL import Image, ImageDraw

from instrument.analysis import Analysis, analyse
from instrument.plan import MotionPlan, Plan
from instrument.session import Instrument
from tests.support.benches import bench_toml
from tests.support.measured import MEASURED

CCD = MEASURED / "spirit" / "Jaszczak_CCD_128x128.png"
NOISE = 'noise = { kind = "pixel", sigma = 0.1, seed = 1 }'


def analysed(folder: Path, scene: str, motion: MotionPlan | None) -> Analysis:
    with Instrument.from_toml(bench_toml(folder, f"{scene}\n{NOISE}")) as bench:
        return analyse(bench.run(Plan(frames=1666, motion=motion), folder / "run.h5"))


def test_a_picture_larger_than_the_image_on_a_trajectory_from_a_file(tmp_path: Path) -> None:
    picture = Image.new("L", (640, 640))
    draw = ImageDraw.Draw(picture)
    draw.ellipse((80, 100, 220, 260), fill=255)
    draw.rectangle((130, 150, 170, 330), fill=120)
    draw.polygon([(240, 120), (300, 260), (200, 240)], fill=200)
    picture.save(tmp_path / "object.png")
    time_s = np.arange(0, 0.51, 0.002)
    x_px = 40 * np.sin(1.8 * np.pi * time_s) ** 2 + 3 * np.sin(18 * np.pi * time_s)
    y_px = 45 * (2 * time_s) ** 1.5 + 2 * np.cos(14 * np.pi * time_s) - 2
    rows = "".join(f"{t:.6f},{x:.6f},{y:.6f}\n" for t, x, y in zip(time_s, x_px, y_px, strict=True))
    (tmp_path / "way.csv").write_text("t_s,x_px,y_px\n" + rows)

    figures = analysed(tmp_path, 'object = "object.png"\ntrajectory = "way.csv"', None).figures
    assert figures.displacement_mse_px2 is not None
    assert figures.psnr_db is not None
    assert figures.displacement_mse_px2 < 0.05
    assert figures.psnr_db > 30


@pytest.mark.skipif(not CCD.is_file(), reason="measured data not there: set KINOPIX_DATA")
def test_a_camera_picture_of_a_real_phantom_is_recognised(tmp_path: Path) -> None:
    """Jaszczak phantom, 56 px high so that it stays in the field.

    The people who took it found r = 0.93 between this picture and their own single-pixel image of the phantom at rest.
    """
    scene = f"object = {str(CCD)!r}\nobject_height_px = 56\nstart_px = [36, 36]"
    analysis = analysed(tmp_path, scene, MotionPlan(velocity_mm_s=25))
    truth = analysis.recording.truth
    assert truth is not None
    assert analysis.reconstruction is not None
    assert analysis.ignored is not None
    place = np.s_[8:64, 8:64]
    found, ignored = (
        np.corrcoef(image[place].ravel(), truth.image[place].ravel())[0, 1]
        for image in (analysis.reconstruction.at_patterns, analysis.ignored)
    )
    assert found > 0.9
    assert ignored < found - 0.2
    assert analysis.figures.displacement_mse_px2 is not None
    assert analysis.figures.displacement_mse_px2 < 0.1
