"""Checks of a plan against the limits of devices, with figures from the data sheets."""

import pytest

from instrument.acquisition import Check, check_plan
from instrument.config import AlignmentSection, Calibration, DisplacementSection, Measured
from instrument.plan import MotionPlan, Plan
from instrument.schemes import FourierHadamardSettings, scheme_of
from protocols import (
    BenchContext,
    CounterLimits,
    KinopixError,
    ModulatorLimits,
    PatternMemoryFull,
    PatternSequence,
    PictureTimeTooShort,
    PlanError,
    TravelExceeded,
)
from sim_backends.bench import OpticalBench, SceneSettings
from sim_backends.devices.stage import StageSettings, open_stage
from tests.support.calibrations import DATE, SIMULATED, displacement

V7000 = ModulatorLimits(
    columns=1024,
    rows=768,
    shortest_picture_time_us=44,
    longest_picture_time_us=10_000_000,
    unique_patterns=43_690,
    play_order_entries=131_072,
)
H10682 = CounterLimits(max_sync_rate_hz=1e6, max_count_rate_hz=5e6, dead_time_s=20e-9)


def checked(
    plan: Plan,
    counter: CounterLimits = H10682,
    known: DisplacementSection | None = None,
    aligned: AlignmentSection | None = None,
) -> dict[str, Check]:
    stage = open_stage(StageSettings(), BenchContext(scene=OpticalBench(SceneSettings())))
    report = check_plan(
        plan,
        sequence=lambda: scheme_of(plan).sequence(),
        modulator=V7000,
        counter=counter,
        stage=stage,
        calibration=None
        if known is None and aligned is None
        else Calibration(bench=SIMULATED, displacement=known, alignment=aligned),
    )
    return {check.name: check for check in report.checks}


def error_of(check: Check) -> KinopixError:
    assert check.outcome == "error"
    assert check.error is not None
    return check.error


def test_the_standard_plan_is_good_and_says_its_figures() -> None:
    checks = checked(Plan(frames=1666, motion=MotionPlan(velocity_mm_s=25)))
    assert {check.outcome for check in checks.values()} == {"good"}
    assert checks["run length"].message == "1666 frames, 9996 patterns, 0.4998 s"
    # Twice 32 bytes a pattern (value and edge time, and both as they arrived), and 1 MiB beside.
    assert checks["disk"].message == "1.7 MB, with a copy while an analysis is stored"
    assert checks["field"].message == "256 x 256 of 1024 x 768 mirrors"
    # 6.25 mm of ramp on both sides of 25 mm/s x (0.2 + 0.4998) s
    assert checks["stage"].message == "0 mm to 29.995 mm, travel 0 to 400 mm; run-up 0.6 s"


def test_22_7_khz_is_the_fastest_that_a_v7000_plays() -> None:
    assert checked(Plan(frames=1, pattern_rate_hz=22_727))["picture time"].outcome == "good"  # 44.0005 us
    error = error_of(checked(Plan(frames=1, pattern_rate_hz=25_000))["picture time"])
    assert isinstance(error, PictureTimeTooShort)
    assert "22727 or less" in error.remedy


def test_a_rate_between_whole_microseconds_is_said() -> None:
    check = checked(Plan(frames=1, pattern_rate_hz=15_000))["picture time"]
    assert check.outcome == "warning"
    assert "67 us, 14925.4 patterns/s" in check.message


def test_a_picture_time_beyond_ten_seconds_is_an_error() -> None:
    error = error_of(checked(Plan(frames=1, pattern_rate_hz=0.05))["picture time"])
    assert "at most 10000000 us" in str(error)


def test_a_field_larger_than_the_mirrors_is_an_error() -> None:
    error = error_of(checked(Plan(frames=1, image_size=256, superpixel=4))["field"])
    assert "at most 768 mirrors" in str(error)


def test_a_play_order_longer_than_the_board_holds_is_an_error() -> None:
    error = error_of(checked(Plan(frames=30_000))["memory"])
    assert isinstance(error, PatternMemoryFull)
    assert "180001 pictures" in str(error)


def test_250_counts_a_pattern_are_the_linear_limit_at_20_khz() -> None:
    """5e6 counts/s in 50 us; a tenth is lost in a dead time of 20 ns."""
    good = checked(Plan(frames=1, brightest_counts=100))["count rate"]
    assert good.outcome == "good"
    assert "4.0 % lost" in good.message
    assert checked(Plan(frames=1, brightest_counts=250))["count rate"].outcome == "warning"
    assert isinstance(error_of(checked(Plan(frames=1, brightest_counts=251))["count rate"]), PlanError)


def test_a_counter_that_is_too_slow_or_too_short_is_an_error() -> None:
    slow = H10682.model_copy(update={"max_sync_rate_hz": 10_000.0, "max_bins": 100})
    checks = checked(Plan(frames=100), slow)
    assert "at most 10000" in str(error_of(checks["sync rate"]))
    assert "at most 100 patterns" in str(error_of(checks["run length"]))


def test_both_ends_of_the_way_must_lie_in_the_travel() -> None:
    checks = checked(Plan(frames=1666, motion=MotionPlan(start_mm=10, velocity_mm_s=-25)))
    error = error_of(checks["stage end"])
    assert isinstance(error, TravelExceeded)
    assert "-19.995 mm" in str(error)


def test_motion_per_frame_is_held_against_the_unambiguous_range() -> None:
    """F = 2/128: half a period is 32 px. A frame of 6 x 50 us at 25 mm/s is 7.5 um."""
    plan = Plan(frames=10, motion=MotionPlan(velocity_mm_s=25))
    assert checked(plan, known=displacement(7.2))["displacement"].message.startswith("0.054 px a frame")
    assert checked(plan, known=displacement(200))["displacement"].outcome == "warning"
    assert "32 px a frame" in str(error_of(checked(plan, known=displacement(5000))["displacement"]))


def test_the_scale_is_that_of_the_pixels_of_the_plan() -> None:
    """At 256 px of one mirror the image is twice as large in pixels: 14.4 px/mm x 7.5 um a frame."""
    plan = Plan(frames=10, image_size=256, superpixel=1, motion=MotionPlan(velocity_mm_s=25))
    known = displacement(14.4, image_size=256, superpixel=1)
    assert checked(plan, known=known)["displacement"].message.startswith("0.108 px a frame")
    refused = str(error_of(checked(plan, known=displacement(7.2))["calibration"]))
    assert "256 px of 1 x 1 mirrors, where [displacement] of the calibration of 2023-04-01" in refused
    assert "holds for 128 px of 2 x 2" in refused


def test_hadamard_patterns_that_repeat_are_said() -> None:
    check = checked(Plan(frames=300, image_size=16, superpixel=2))["run length"]
    assert check.outcome == "warning"
    assert "repeat after 256 frames" in check.message


@pytest.mark.parametrize("cycles", [1, 4])
def test_the_range_follows_the_fringes(cycles: int) -> None:
    message = checked(Plan(frames=1, scheme=FourierHadamardSettings(fourier_cycles=cycles)))["displacement"].message
    assert f"within {64 / cycles:g} px" in message


def memory_checked(available: int | None) -> tuple[dict[str, Check], int]:
    """The checks of the standard plan on a computer with so much memory, and how often its patterns were made."""
    plan, made = Plan(frames=1666), list[int]()

    def sequence() -> PatternSequence:
        made.append(1)
        return scheme_of(plan).sequence()

    stage = open_stage(StageSettings(), BenchContext(scene=OpticalBench(SceneSettings())))
    report = check_plan(
        plan, sequence=sequence, modulator=V7000, counter=H10682, stage=stage, memory_bytes=lambda: available
    )
    return {check.name: check for check in report.checks}, len(made)


def test_a_plan_that_does_not_fit_into_this_computer_is_refused_before_its_patterns_are_made() -> None:
    """230 MB, 68.2 MB for pixels, for 9,996 patterns 1.28 MB (299,518,848 bytes) or, analysed, 10.2 MB (308,475,264 bytes)."""
    checks, made = memory_checked(308_475_264)
    assert checks["computer memory"].message == "308 MB for the run and its analysis; 308 MB are left"
    assert made == 1
    for available in (308_475_263, 299_518_848):
        checks, made = memory_checked(available)
        assert checks["computer memory"].outcome == "warning"
        assert "300 MB for the run; 308 MB with its analysis at once" in checks["computer memory"].message
        assert "--window" in checks["computer memory"].message
        assert made == 1
    checks, made = memory_checked(299_518_847)
    error = error_of(checks["computer memory"])
    assert isinstance(error, PlanError)
    assert "saw a plan that takes 300 MB to record" in str(error)
    assert made == 0
    checks, _ = memory_checked(None)
    assert checks["computer memory"].outcome == "warning"


def test_whether_the_picture_is_mirrored_is_asked_until_it_was_aligned() -> None:
    plan = Plan(frames=10)
    asked = checked(plan)["wiring"]
    assert asked.outcome == "good"
    assert "`kinopix calibrate alignment`" in asked.message
    assert "against the stage's axis it will be seen" in checked(plan, known=displacement())["wiring"].message

    upright = AlignmentSection(
        date=DATE,
        orientation="upright",
        turn_deg=Measured(value=0.0, sigma=1.0),
        certainty=50.0,
        wiring="as planned",
        target_height_px=40.0,
        image_size=128,
        superpixel=2,
    )
    found = checked(plan, aligned=upright)["wiring"]
    assert (found.outcome, found.message) == (
        "good",
        "patterns as planned, the picture upright, by the alignment of 2023-04-01",
    )
    for other in ({"orientation": "mirrored"}, {"wiring": "H- first"}):
        assert checked(plan, aligned=upright.model_copy(update=other))["wiring"].outcome == "warning"
