"""Figures of merit: their values by hand, what they say, and when they doubt."""

import numpy as np
import pytest

from instrument.analysis import Figures, figures_of
from instrument.measurement import Measurement
from instrument.plan import Plan
from instrument.reconstruction import Reconstruction, Region
from instrument.recording import Recording
from instrument.tracking import Trajectory
from protocols import Floats, Truth

FRAMES, SIZE = 20, 16
PLAIN = Figures(
    frames=8, frames_masked=1, travel_px=None, sigma_px=None, misfit=None, light_change=0.0, analysis_s=0.126
)


def measured(light: Floats, *, photon_counts: bool = False) -> Measurement:
    """Four values a frame are each ``light``: H+ and H- sum to twice that. One fringe an axis is brighter, as by an object."""
    values = np.repeat(np.broadcast_to(light, (FRAMES,))[:, None], 6, axis=1) * [1.8, 1.0, 1.8, 1.0, 1.0, 1.0]
    valid = np.arange(FRAMES) != 3
    plan = Plan(frames=FRAMES, image_size=SIZE)
    return Measurement.of(Recording(plan, values, valid, 50e-6, photon_counts=photon_counts))


def path_of(displacement_px: Floats, sigma_px: float = 0.25) -> Trajectory:
    sigma = np.full((FRAMES, 2), sigma_px)
    return Trajectory(displacement_px, sigma, 300e-6, "smooth", np.ones(FRAMES, np.bool_))


def image_of(image: Floats, misfit: float = 1.0) -> Reconstruction:
    return Reconstruction(image, "tv", 1.0, 0.1, misfit, 7, Region.whole(SIZE), Region.whole(SIZE))


STEPS = np.outer(np.arange(FRAMES), [1.0, -0.5])
SQUARE = np.zeros((SIZE, SIZE))
SQUARE[4:8, 6:10] = 1.0


def test_frames_are_counted_and_masked_ones_among_them() -> None:
    figures = figures_of(measured(np.array(50.0)), None, None, None, 0.5)
    assert (figures.frames, figures.frames_masked, figures.analysis_s) == (20, 1, 0.5)
    assert figures.light_change == 0
    assert (figures.travel_px, figures.sigma_px, figures.misfit, figures.psnr_db) == (None,) * 4
    assert figures.doubts == ()


def test_without_a_truth_travel_and_uncertainty_are_all_that_is_said_of_a_path() -> None:
    path = path_of(STEPS)
    path.sigma_px[:5] = 9.0  # the median does not mind
    figures = figures_of(measured(np.array(50.0)), None, path, image_of(SQUARE, misfit=1.25), 0.5)
    assert figures.travel_px == (19.0, -9.5)
    assert figures.sigma_px == 0.25
    assert figures.misfit == 1.25
    needing_truth = (figures.displacement_mse_px2, figures.psnr_db, figures.ssim_global, figures.ssim_local)
    assert needing_truth == (None,) * 4


def test_errors_against_the_truth_by_hand() -> None:
    """X is 0.2 px off everywhere, y by 0.4 px in every other frame: means of 0.04 and 0.08, of which 0 and 0.04 are left."""
    truth = Truth(displacement_px=STEPS, image=SQUARE)
    off = np.stack([np.full(FRAMES, 0.2), 0.4 * (np.arange(FRAMES) % 2)], axis=1)
    figures = figures_of(measured(np.array(50.0)), truth, path_of(STEPS + off), image_of(SQUARE + 0.1), 0.5)
    assert figures.displacement_mse_px2 == pytest.approx((0.04 + 0.08) / 2)
    assert figures.displacement_mse_offset_free_px2 == pytest.approx((0 + 0.04) / 2)
    # 240 of 256 pixels are 0.1 too bright, the others clipped to 1
    assert figures.psnr_db == pytest.approx(-10 * np.log10(0.01 * 240 / 256))


def test_an_exact_image_has_300_db_and_a_similarity_of_one() -> None:
    truth = Truth(displacement_px=STEPS, image=SQUARE)
    figures = figures_of(measured(np.array(50.0)), truth, None, image_of(SQUARE), 0.5)
    assert figures.psnr_db == 300.0
    assert figures.ssim_global == pytest.approx(1.0)
    assert figures.ssim_local == pytest.approx(1.0)


def test_only_photon_counts_are_given_a_gain() -> None:
    """Half as bright as the truth: the same image for a counter without a scale, an error of 1/4 in 16 of 256 pixels else."""
    truth = Truth(displacement_px=STEPS, image=SQUARE)
    photons = figures_of(measured(np.array(50.0), photon_counts=True), truth, None, image_of(SQUARE / 2), 0.5)
    values = figures_of(measured(np.array(50.0)), truth, None, image_of(SQUARE / 2), 0.5)
    assert photons.psnr_db == 300.0
    assert photons.ssim_global == pytest.approx(1.0)
    assert photons.ssim_local == pytest.approx(1.0)
    assert values.psnr_db == pytest.approx(10 * np.log10(4 * 16))
    assert values.ssim_global is not None
    assert values.ssim_global < 0.95


def test_what_is_not_known_is_none_and_not_infinite() -> None:
    figures = figures_of(
        measured(np.array(50.0)), None, path_of(STEPS, np.inf), image_of(SQUARE, misfit=float("nan")), 0.5
    )
    assert figures.sigma_px is None
    assert figures.misfit is None
    assert [doubt.split(" for an image")[0] for doubt in figures.doubts] == ["19 frames are too few"]


@pytest.mark.parametrize(("last", "doubted"), [(104.9, False), (105.1, True), (95.1, False), (94.9, True)])
def test_a_change_of_the_light_by_a_twentieth_is_doubted(last: float, *, doubted: bool) -> None:
    """Ten parts of two frames, one of them of another light: the median is 100."""
    light = np.full(FRAMES, 50.0)
    light[-2:] = last / 2
    figures = figures_of(measured(light), None, None, None, 0.5)
    assert figures.light_change == pytest.approx(abs(last / 100 - 1))
    assert [doubt.split(" in the run")[0] for doubt in figures.doubts] == (
        ["the field's total light changed by 5 %"] if doubted else []
    )


@pytest.mark.parametrize(("misfit", "doubted"), [(1.5, False), (1.6, True)])
def test_a_misfit_above_one_and_a_half_is_doubted(misfit: float, *, doubted: bool) -> None:
    figures = figures_of(measured(np.array(50.0)), None, None, image_of(SQUARE, misfit), 0.5)
    assert [doubt.split(": doubt both")[0] for doubt in figures.doubts if "too few for an image" not in doubt] == (
        ["motion and image leave 1.6 times the noise unexplained"] if doubted else []
    )


def test_the_figures_as_a_person_reads_them() -> None:
    full = PLAIN.model_copy(
        update={
            "travel_px": (12.345, -0.5),
            "sigma_px": 0.04567,
            "misfit": 1.0156,
            "displacement_mse_px2": 0.01234,
            "displacement_mse_offset_free_px2": 0.00567,
            "psnr_db": 33.26,
            "ssim_global": 0.98765,
            "ssim_local": 0.91234,
        }
    )
    assert full.rows() == {
        "frames": "8, 1 masked",
        "travel": "12.35, -0.50 px",
        "stated uncertainty": "0.046 px (median, one sigma)",
        "displacement MSE": "0.0123 px^2 (0.0057 offset-free)",
        "PSNR": "33.3 dB",
        "SSIM": "0.9877 global, 0.9123 local",
        "misfit": "1.016 (1 is the noise alone)",
        "analysis": "0.13 s",
    }
    assert full.caption() == "8 frames, displacement MSE 0.0123 px², image PSNR 33.3 dB"


def test_figures_that_are_not_known_have_no_row() -> None:
    assert PLAIN.rows() == {"frames": "8, 1 masked", "analysis": "0.13 s"}
    assert PLAIN.caption() == "8 frames"
    unsure = PLAIN.model_copy(update={"travel_px": (1.0, 2.0)})
    assert unsure.rows()["stated uncertainty"] == "-"
    sure = PLAIN.model_copy(update={"sigma_px": 0.125})
    assert sure.caption() == "8 frames, displacement known to 0.125 px"


def test_light_that_comes_back_is_judged_by_its_worst_tenth() -> None:
    """Frame 3 is masked, so that frames 7 and 8 are the fourth tenth."""
    light = np.full(FRAMES, 50.0)
    light[7:9] = 40.0
    assert figures_of(measured(light), None, None, None, 0.5).light_change == pytest.approx(0.2)
