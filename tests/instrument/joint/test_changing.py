"""An object that turns or grows a little while it moves: noticed, followed, told; and a rigid one left as it is."""

import importlib
from functools import cache

import numpy as np
import pytest

from instrument import Plan, simulate
from instrument.analysis import Analysis, analyse
from instrument.choices import Shape
from instrument.joint.changing import change_text
from instrument.numerics import displacement_mse
from instrument.tracking import Trajectory
from protocols import Floats, InputError

FRAMES, SIZE = 600, 64

MIDDLE_PX = np.array([19.5, 21.5])
"""Of the rectangle around the letter, about which the bench turns it."""

CENTROID_PX = np.array([(160 * 10.0 + 95 * 22.0 + 50 * 17.5) / 305, (160 * 21.5 + 95 * 8.0 + 50 * 20.0) / 305])
"""Of the letter: strokes of 160, 95 and 50 px, whose middles are at (10, 21.5), (22, 8) and (17.5, 20)."""


def _letter() -> Floats:
    """An "F" of strokes 5 px thick, 32 px high and 24 px wide: no symmetry hides a turn."""
    image = np.zeros((SIZE, SIZE))
    image[6:38, 8:13] = 1.0
    image[6:11, 13:32] = 1.0
    image[18:23, 13:23] = 1.0
    return image


@cache
def _analysed(turn_deg: float = 0.0, growth: float = 0.0, shape: Shape = "auto") -> Analysis:
    """Go 16 px across and 13 px down, with a noise of 0.05 on every pixel."""
    plan = Plan(frames=FRAMES, image_size=SIZE)

    def path(time_s: Floats) -> Floats:
        part = time_s / plan.run_time_s
        return np.stack([14 * part + 2 * part**2, 11 * part + 2 * part**2], axis=1)

    scene = {
        "noise": {"kind": "pixel", "sigma": 0.05, "seed": 3},
        "object_turn_deg": turn_deg,
        "object_growth": growth,
    }
    return analyse(simulate(plan, scene, image=_letter(), path=path), shape=shape)


def _path(found: Analysis) -> Trajectory:
    assert found.trajectory is not None
    return found.trajectory


def _error_px2(found: Analysis, turn_deg: float = 0.0, growth: float = 0.0) -> float:
    """Mean squared error against the path of the centroid: the bench turns objects about the middle of their rectangle."""
    truth = found.recording.truth
    assert truth is not None
    part = np.arange(FRAMES) / FRAMES
    angle, size = np.deg2rad(turn_deg) * part, 1 + growth * part
    x, y = CENTROID_PX - MIDDLE_PX
    turned = np.stack([x * np.cos(angle) - y * np.sin(angle), x * np.sin(angle) + y * np.cos(angle)], axis=1)
    of_centroid = truth.displacement_px + size[:, None] * turned - [x, y]
    return displacement_mse(_path(found).displacement_px, of_centroid)


def _db(found: Analysis) -> float:
    assert found.figures.psnr_db is not None
    return found.figures.psnr_db


def test_a_rigid_object_is_left_as_it_is() -> None:
    """To the bit, and nothing is said."""
    auto, rigid = _analysed(), _analysed(shape="rigid")
    assert _path(auto).angle_deg is None
    assert _path(auto).magnification is None
    assert _path(auto).pivot_px is None
    assert not auto.figures.found
    assert auto.figures.turn_deg is None
    assert auto.figures.growth is None
    np.testing.assert_array_equal(_path(auto).displacement_px, _path(rigid).displacement_px)
    assert auto.image is not None
    assert rigid.image is not None
    np.testing.assert_array_equal(auto.image, rigid.image)


def test_a_turn_is_noticed_and_followed() -> None:
    """4 degrees clockwise. Taken for rigid, the image is 13 dB worse than that of an object that does not turn."""
    found = _analysed(turn_deg=4.0)
    path = _path(found)
    assert path.angle_deg is not None
    assert path.angle_sigma_deg is not None
    assert path.angle_deg[0] == 0
    assert path.angle_sigma_deg[0] == 0
    assert abs(path.angle_deg[-1] - 4) < 2 * path.angle_sigma_deg[-1] < 1.5
    np.testing.assert_allclose(path.angle_deg[FRAMES // 2] / path.angle_deg[-1], 0.5, atol=0.1)
    assert _error_px2(found, turn_deg=4.0) < 0.01
    assert _db(found) > _db(_analysed()) - 4
    assert found.figures.turn_deg == path.angle_deg[-1]
    assert found.figures.turn_sigma_deg == path.angle_sigma_deg[-1]
    (told,) = found.figures.found
    assert told.startswith(f"the object turned by {path.angle_deg[-1]:+.1f} +- ")
    assert any(doubt.startswith(told) and "its centroid" in doubt for doubt in found.figures.doubts)
    assert path.pivot_px is not None
    np.testing.assert_allclose(path.pivot_px, CENTROID_PX, atol=0.3)


@pytest.mark.parametrize("growth", [-0.04, pytest.param(0.04, marks=pytest.mark.thorough)])
def test_growth_is_noticed_and_followed(growth: float) -> None:
    """4 % either way. The light that grows with the area is divided out as if it were the lamp's, and is put back."""
    found = _analysed(growth=growth)
    path = _path(found)
    assert path.magnification is not None
    assert path.magnification_sigma is not None
    assert path.magnification[0] == 1
    assert path.magnification_sigma[0] == 0
    assert abs(path.magnification[-1] - 1 - growth) < 3 * path.magnification_sigma[-1] < 0.03
    assert _error_px2(found, growth=growth) < 0.01
    assert _db(found) > _db(_analysed()) - 4
    assert found.figures.growth == pytest.approx(path.magnification[-1] - 1)
    assert found.figures.growth_sigma == path.magnification_sigma[-1]
    assert found.figures.rows()["growth"].startswith(f"{100 * (path.magnification[-1] - 1):+.1f} % (+- ")
    (told,) = found.figures.found
    assert told.startswith("the object grew by " + ("+" if growth > 0 else "-"))


def test_a_rigid_object_asked_for_its_shape_has_none_to_speak_of() -> None:
    """Both numbers are told with their uncertainty, and hold 0."""
    found = _analysed(shape="changing")
    path = _path(found)
    assert path.angle_deg is not None
    assert path.angle_sigma_deg is not None
    assert path.magnification is not None
    assert path.magnification_sigma is not None
    assert abs(path.angle_deg[-1]) < 2 * path.angle_sigma_deg[-1]
    assert abs(path.magnification[-1] - 1) < 2 * path.magnification_sigma[-1]
    (told,) = found.figures.found
    assert "turned by" in told
    assert "grew by" in told
    assert _error_px2(found) < 0.005


def test_what_is_told_is_what_is_significant() -> None:
    def path(turn_deg: float, growth: float, turn_sigma_deg: float = 0.5) -> Trajectory:
        end = np.array([0.0, 1.0])
        return Trajectory(
            np.zeros((2, 2)),
            np.zeros((2, 2)),
            3e-4,
            "joint",
            np.ones(2, np.bool_),
            angle_deg=turn_deg * end,
            angle_sigma_deg=turn_sigma_deg * end,
            magnification=1 + growth * end,
            magnification_sigma=0.01 * end,
        )

    assert change_text(path(1.5, 0.0)) == "the object turned by +1.5 +- 0.5 degrees in the run"
    assert change_text(path(-0.2, 0.0, 0.04)) == "the object turned by -0.20 +- 0.04 degrees in the run"
    assert change_text(path(1.4, -0.03)) == "the object grew by -3.0 +- 1.0 % in the run"
    both = "the object turned by -2.0 +- 0.5 degrees and grew by +4.0 +- 1.0 % in the run"
    assert change_text(path(-2.0, 0.04)) == both
    neither = "the object turned by +1.4 +- 0.5 degrees and grew by +2.9 +- 1.0 % in the run"
    assert change_text(path(1.4, 0.029)) == neither


def test_a_shape_that_nothing_follows_is_refused() -> None:
    recording = _analysed().recording
    with pytest.raises(InputError, match="a changing shape with the tracking joint and the method dgi"):
        analyse(recording, shape="changing", method="dgi")
    with pytest.raises(InputError, match="a changing shape with the tracking smooth and the method tv"):
        analyse(recording, shape="changing", tracking="smooth")
    with pytest.raises(InputError, match="the shape 'round'"):
        analyse(recording, shape="round")  # type: ignore[arg-type]  # pyright: ignore[reportArgumentType]


def test_a_run_whose_rows_are_too_many_to_write_out_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(importlib.import_module("instrument.joint.changing"), "_ENTRIES", 1)
    found = analyse(_analysed().recording.first(100), shape="changing")
    assert found.figures.found == ("the object's shape was not followed",)
    assert any("100 frames are too many to follow it" in doubt for doubt in found.figures.doubts)
    assert found.figures.turn_deg is None
