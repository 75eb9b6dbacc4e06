"""A recording as a value: its times, its beginning, and what may be taken off it."""

from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from instrument.plan import MotionPlan, Plan
from instrument.recording import Recording, TimingReport
from protocols import InputError, Truth

PLAN = Plan(frames=5, image_size=16)


def _recording(frames: int = 4) -> Recording:
    """Give values 0, 1, 2, ... in play order, with everything that a frame can have."""
    values = np.arange(frames * 6.0).reshape(frames, 6)
    return Recording(
        plan=PLAN,
        values=values,
        frame_valid=np.arange(frames) != 1,
        picture_time_s=1 / 8192,
        edge_time_s=values / 8192,
        background=-values,
        truth=Truth(displacement_px=values[:, :2], image=np.eye(16)),
        dead_time_s=2e-8,
    )


def test_times_follow_from_that_of_a_picture() -> None:
    """1 / 8192 s a picture, six a frame; the middle of picture 7 is 7.5 of them after the first edge."""
    recording = _recording()
    assert len(recording) == 4
    assert recording.frame_time_s == 6 / 8192
    assert recording.pattern_time_s.shape == (4, 6)
    assert recording.pattern_time_s[1, 1] == 7.5 / 8192
    assert recording.pattern_time_s[0, 0] == 0.5 / 8192


@settings(deadline=None)
@given(frames=st.integers(0, 6), again=st.integers(0, 6))
def test_the_first_frames_of_the_first_frames_are_the_first_frames(frames: int, again: int) -> None:
    """All that is known frame by frame is cut alike; what is known of the run stays."""
    whole = _recording()
    part = whole.first(frames).first(again)
    kept = min(4, frames, again)
    assert len(part) == kept
    assert part.truth is not None
    assert part.edge_time_s is not None
    assert part.background is not None
    np.testing.assert_array_equal(part.values, whole.values[:kept])
    np.testing.assert_array_equal(part.edge_time_s, whole.values[:kept] / 8192)
    np.testing.assert_array_equal(part.background, -whole.values[:kept])
    np.testing.assert_array_equal(part.truth.displacement_px, whole.values[:kept, :2])
    assert part.frame_valid.tolist() == [True, False, True, True][:kept]
    assert (part.plan, part.dead_time_s) == (PLAN, 2e-8)
    assert part.truth.image.shape == (16, 16)


def test_what_is_not_there_is_not_there_in_the_first_frames_either() -> None:
    bare = replace(_recording(), edge_time_s=None, background=None, truth=None).first(2)
    assert (bare.edge_time_s, bare.background, bare.truth) == (None, None, None)


def test_a_background_may_be_longer_and_without_the_motion_and_masks_its_own_bad_frames() -> None:
    """Frame 1 is bad here and frame 2 there: 0 and 3 are left. Its fifth frame is not used."""
    moving = PLAN.model_copy(update={"motion": MotionPlan(velocity_mm_s=1.0)})
    recording = replace(_recording(), plan=moving, background=None)
    behind = replace(
        _recording(5),
        plan=PLAN.model_copy(update={"frames": 900}),
        background=None,
        frame_valid=np.array([True, True, False, True, False]),
    )
    found = recording.minus(behind)
    assert found.frame_valid.tolist() == [True, False, False, True]
    assert found.background is not None
    np.testing.assert_array_equal(found.background, behind.values[:4])
    np.testing.assert_array_equal(found.values, recording.values)
    assert found.plan == moving
    assert recording.background is None


def test_a_background_that_is_shorter_or_of_other_patterns_is_refused() -> None:
    recording = replace(_recording(), background=None)
    with pytest.raises(InputError, match=r"a background of 3 frames.*at least 4 frames"):
        recording.minus(recording.first(3))
    other = replace(recording, plan=PLAN.model_copy(update={"image_size": 32}))
    with pytest.raises(InputError, match=r"a background of 4 frames.*\"image_size\":32"):
        recording.minus(other)


_COUNT = st.integers(0, 10**9)
_MAYBE = st.none() | st.floats(allow_nan=False, allow_infinity=False)
_PATTERNS = st.lists(st.integers(0, 10**6), max_size=4).map(tuple)


@settings(deadline=None)
@given(
    report=st.builds(
        TimingReport,
        verdict=st.sampled_from(["good", "flagged", "failed"]),
        patterns_expected=_COUNT,
        patterns_recorded=_COUNT,
        bins_received=_COUNT,
        edges_seen=st.none() | _COUNT,
        surplus_edges=st.none() | _COUNT,
        picture_time_s=st.floats(1e-9, 1e3),
        mean_period_s=_MAYBE,
        jitter_s=_MAYBE,
        largest_deviation_s=_MAYBE,
        clock_offset_ppm=_MAYBE,
        gaps=_PATTERNS,
        doubles=_PATTERNS,
        irregular=_PATTERNS,
        frames=_COUNT,
        frames_masked=_COUNT,
        brightest_rate_hz=_MAYBE,
        nonlinear_patterns=_COUNT,
        notes=st.lists(st.text(max_size=9), max_size=3).map(tuple),
    )
)
def test_a_timing_report_comes_back_from_json_to_the_last_digit(report: TimingReport) -> None:
    assert TimingReport.model_validate_json(report.model_dump_json()) == report


@pytest.mark.parametrize(
    "change", [{"picture_time_s": 0.0}, {"frames": -1}, {"verdict": "fair"}, {"jitter_s": float("inf")}, {"colour": 1}]
)
def test_a_timing_report_of_impossible_figures_is_refused(change: dict[str, object]) -> None:
    unknown = ("edges_seen", "surplus_edges", "mean_period_s", "jitter_s", "largest_deviation_s", "clock_offset_ppm")
    figures: dict[str, object] = {name: None for name in unknown}  # noqa: C420 - its type would be that of the names
    figures |= {"verdict": "good", "patterns_expected": 6, "patterns_recorded": 6, "bins_received": 6}
    figures |= {"picture_time_s": 5e-5}
    assert TimingReport.model_validate(figures).frames == 0
    with pytest.raises(ValidationError):
        TimingReport.model_validate(figures | change)


def test_a_part_tells_of_its_own_patterns_and_frames() -> None:
    """Of 4 frames of 6 patterns the last two: patterns 12 to 23, counted from 12."""
    report = TimingReport(
        verdict="flagged",
        patterns_expected=24,
        patterns_recorded=24,
        bins_received=24,
        edges_seen=None,
        surplus_edges=None,
        picture_time_s=1 / 8192,
        mean_period_s=None,
        jitter_s=None,
        largest_deviation_s=None,
        clock_offset_ppm=None,
        gaps=(11, 12, 23),
        doubles=(3,),
        irregular=(17,),
        slipped=((0, 1, 1), (1, 3, -1), (3, 4, 2)),
        frames=4,
    )
    part = replace(_recording(), timing=report).part(2, 4)
    assert part.values[:, 0].tolist() == [12.0, 18.0]
    assert part.frame_valid.tolist() == [True, True]
    assert part.timing is not None
    assert (part.timing.gaps, part.timing.doubles, part.timing.irregular) == ((0, 11), (), (5,))
    assert part.timing.slipped == ((0, 1, -1), (1, 2, 2))
    assert part.timing.frames == 2
    assert part.background is not None
    assert part.background[0, 0] == -12.0
    with pytest.raises(InputError, match="frames 2 to 5"):
        _recording().part(2, 5)
