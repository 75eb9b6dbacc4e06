"""Alignment: which way the image lies, how patterns are wired, which way the stage goes."""

import itertools
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from instrument.calibration import (
    PictureField,
    calibrate_alignment,
    laid,
    match_target,
    place_of,
    target_letter,
    upright,
)
from instrument.config import ORIENTATIONS, Orientation, bench_of_tables, upright_angle_deg
from instrument.session import Instrument
from instrument.views import alignment_figure
from protocols import Floats, InputError

LETTER = target_letter()


def bench_with(folder: Path, orientation: Orientation, scene: dict[str, Any]) -> Instrument:
    """A bench with the letter F in some way in the light, 18 px high, 50 counts a white pattern."""
    cells = laid(LETTER, orientation)
    np.save(folder / "target.npy", cells)
    devices = {role: {"driver": "simulated"} for role in ("modulator", "counter", "stage")}
    light = {"kind": "poisson", "peak_counts": 50, "dark_rate_hz": 600.0, "seed": 1}
    lies = {"object": str(folder / "target.npy"), "object_height_px": 18 * len(cells) / 40, "start_px": [31.3, 32.8]}
    tables = {**devices, "scene": {**lies, "px_per_mm": 3.6, "noise": light, "fresh_noise": True, **scene}}
    return Instrument.from_config(bench_of_tables(tables, "test"))


def drawn(orientation: Orientation, row: int, column: int) -> Floats:
    """The letter, 20 px high, on 64 px."""
    image = np.zeros((64, 64))
    cells = laid(LETTER, orientation).reshape(len(laid(LETTER, orientation)) // 2, 2, -1, 2).mean(axis=(1, 3))
    image[row : row + cells.shape[0], column : column + cells.shape[1]] = cells
    return image


def test_the_eight_ways_by_hand() -> None:
    """A 1 in the upper left corner of two rows of three: where it is afterwards."""
    cells = np.array([[1.0, 2.0, 3.0], [4.0, 5.0, 6.0]])
    assert laid(cells, "upright").tolist() == cells.tolist()
    assert laid(cells, "turned 90").tolist() == [[4, 1], [5, 2], [6, 3]]
    assert laid(cells, "turned 180").tolist() == [[6, 5, 4], [3, 2, 1]]
    assert laid(cells, "mirrored").tolist() == [[3, 2, 1], [6, 5, 4]]
    assert laid(cells, "mirrored, turned 90").tolist() == [[6, 3], [5, 2], [4, 1]]


@pytest.mark.parametrize("orientation", ORIENTATIONS)
def test_an_image_and_a_direction_are_turned_upright_alike(orientation: Orientation) -> None:
    """A bar that points somewhere in the upright picture is laid, and its direction there turned back."""
    cells = np.arange(12.0).reshape(3, 4)
    np.testing.assert_array_equal(upright(laid(cells, orientation), orientation), cells)
    spot = np.zeros((9, 9))
    spot[6, 7] = 1.0  # from the middle (4, 4): 3 to the right, 2 down
    row, column = np.argwhere(laid(spot, orientation) == 1)[0]
    angle = float(np.degrees(np.arctan2(row - 4, column - 4)))
    assert upright_angle_deg(angle, orientation) == pytest.approx(np.degrees(np.arctan2(2, 3)))


@pytest.mark.parametrize(
    "orientation",
    ["upright", "turned 180", "mirrored, turned 90"]
    + [
        pytest.param(way, marks=pytest.mark.thorough)
        for way in ORIENTATIONS
        if way not in {"upright", "turned 180", "mirrored, turned 90"}
    ],
)
def test_a_drawn_letter_is_found_where_it_is(orientation: Orientation) -> None:
    image = drawn(orientation, 17, 23) + 0.05 * np.random.default_rng(1).standard_normal((64, 64))
    match = match_target(image, LETTER)
    assert match.orientation == orientation
    assert match.height_px == pytest.approx(20, abs=1.5)
    assert abs(match.turn_deg) <= 6
    assert match.certainty > 100
    assert match.corner_px == pytest.approx((23, 17), abs=2.5)


def test_a_place_is_found_to_a_fraction_of_a_pixel() -> None:
    """A smooth spot, moved by (5.3, -2.6) px."""
    x = np.arange(64.0)

    def spot(column: float, row: float) -> Floats:
        return np.exp(-((x - column) ** 2 + (x[:, None] - row) ** 2) / 8)

    template = spot(30, 30)[24:37, 24:37]
    noise = 0.01 * np.random.default_rng(2).standard_normal((64, 64))
    (here, _), (there, sigma) = (place_of(spot(*at) + noise, template) for at in ((30, 30), (35.3, 27.4)))
    assert there - here == pytest.approx([5.3, -2.6], abs=0.1)
    assert here == pytest.approx([24, 24], abs=0.05)
    assert sigma == pytest.approx(0.15, rel=0.2)


@pytest.mark.parametrize(
    ("orientation", "wiring", "scene"),
    [
        ("upright", "as planned", {}),
        ("turned 90", "H- first", {"swap": {}}),
        ("mirrored", "inverted", {"mirrors_inverted": True}),
        ("mirrored, turned 270", "as planned", {"mirror_transition_s": 4e-6, "edge_loss": 0.02}),
    ],
)
def test_a_bench_with_its_flaws_is_told(
    tmp_path: Path, orientation: Orientation, wiring: str, scene: dict[str, Any]
) -> None:
    with bench_with(tmp_path, orientation, {"axis_angle_deg": 30.0, **scene}) as bench:
        found = calibrate_alignment(bench, PictureField(tmp_path, 64, 4), step_mm=2.0)
        assert bench.stage.position().reported_mm == pytest.approx(0.0, abs=0.01)
    section = found.section
    assert section.orientation == orientation
    assert section.wiring == wiring
    assert section.certainty > 100
    assert section.target_height_px == pytest.approx(18, rel=0.15)
    assert section.axis_angle_deg is not None
    assert section.px_per_mm is not None
    assert section.axis_angle_deg.value == pytest.approx(30, abs=4 * section.axis_angle_deg.sigma)
    assert section.axis_angle_deg.sigma < 3
    assert section.px_per_mm.value == pytest.approx(3.6, abs=4 * section.px_per_mm.sigma)
    assert found.well == (orientation == "upright" and wiring == "as planned")
    sentences = " ".join(found.verdict)
    assert ("mirrored" in sentences) == ("mirrored" in orientation)
    assert ("degrees clockwise" in sentences) == ("turned" in orientation)
    assert ("other side of the modulator" in sentences) == (wiring == "inverted")
    assert ("H- is shown before H+" in sentences) == (wiring == "H- first")
    alignment_figure(found)


def test_the_stage_may_go_backwards_and_is_said_where_it_carries_nothing(tmp_path: Path) -> None:
    with bench_with(tmp_path, "upright", {"axis_angle_deg": -60.0, "object_at_mm": 0.0}) as bench:
        bench.stage.move_to(4.0, bench_profile(bench)).wait()
        found = calibrate_alignment(bench, PictureField(tmp_path / "a", 64, 4), step_mm=-3.0, frames=512)
    assert found.section.axis_angle_deg is not None
    assert found.section.axis_angle_deg.value == pytest.approx(-60, abs=5)
    with bench_with(tmp_path, "upright", {"px_per_mm": 0.01}) as bench:
        found = calibrate_alignment(bench, PictureField(tmp_path / "b", 64, 4), step_mm=2.0, frames=512)
    assert "whether the stage carries it" in " ".join(found.verdict)


def bench_profile(bench: Instrument) -> Any:
    from protocols import MotionProfile

    return MotionProfile(velocity_mm_s=bench.stage.limits.max_velocity_mm_s, acceleration_mm_s2=100.0)


def test_without_a_target_or_near_the_border_it_says_so(tmp_path: Path) -> None:
    with bench_with(tmp_path, "upright", {"start_px": [10.0, 32.0]}) as bench:
        found = calibrate_alignment(bench, PictureField(tmp_path / "a", 64, 4), frames=512)
    assert "near the left border" in " ".join(found.verdict)
    assert found.section.axis_angle_deg is None
    dark = {"object_level": 0.0, "ambient_level": 1.0}
    with bench_with(tmp_path, "upright", dark) as bench, pytest.raises(InputError, match="no target"):
        calibrate_alignment(bench, PictureField(tmp_path / "b", 64, 4), frames=512)


def test_every_two_ways_differ() -> None:
    shapes = [laid(np.pad(LETTER, ((0, 0), (0, 12))), way) for way in ORIENTATIONS]
    assert min(float(np.abs(a - b).mean()) for a, b in itertools.combinations(shapes, 2)) > 0.1
