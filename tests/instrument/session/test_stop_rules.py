"""``[stop_if]``: by hand, frame by frame; and on simulated benches, where the run ends safe with what it had."""

from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from instrument.acquisition import check_recording
from instrument.cli.main import status
from instrument.config import StopTable
from instrument.plan import Plan
from instrument.session import FinishedEvent, Instrument, RunStopped
from instrument.session.stop_rules import Light, StopRules
from instrument.storage import open_recording, recording_info
from protocols import Floats, Mask
from tests.support.benches import bench_toml

PICTURE_S = 50e-6
FRAME_S = 6 * PICTURE_S
"""A frame of six patterns at 20 kHz."""

LIGHT = Light(limit_hz=5e6, dark_rate_hz=1000.0)
"""Linear up to 250 counts a pattern; 0.05 dark counts in one, 0.3 in a frame."""


def plan_of(**rules: float) -> Plan:
    return Plan(frames=1000, image_size=32, superpixel=4, stop_if=StopTable(**rules))


def seen(
    plan: Plan, values: Floats, valid: Mask | None = None, *, photons: bool = True, cuts: tuple[int, ...] = ()
) -> RunStopped | None:
    """Hand the values over in blocks that end at ``cuts``; give the first answer."""
    rules, mask = StopRules(plan, LIGHT), np.ones(values.size, bool) if valid is None else valid
    edges = [0, *cuts, values.size]
    answers = [rules.see(values.ravel()[a:b], mask[a:b], photon_counts=photons) for a, b in pairwise(edges)]
    return next((answer for answer in answers if answer is not None), None)


def frames_of(*levels: float) -> Floats:
    """Frames whose six patterns have these counts each."""
    return np.repeat(np.array(levels, float), 6)


def test_too_bright_must_hold_in_every_frame_of_its_time() -> None:
    """251 counts in 50 us are above 5e6 a second, 250 are not. Three frames are 0.9 ms; one of the six patterns is enough."""
    plan = plan_of(too_bright_s=3 * FRAME_S)
    values = frames_of(*[100] * 10).reshape(10, 6)
    for frame in (1, 2, 4, 5, 6):
        values[frame, frame % 6] = 251
    values[8, 0] = 250
    stopped = seen(plan, values)
    assert stopped is not None
    assert (stopped.rule, stopped.pattern, stopped.exit_code) == ("too_bright_s", 42, 4)
    assert "stop_if.too_bright_s = 0.0009 at pattern 42: frames 4 to 6 have a pattern above" in str(stopped)
    values[5, 5] = 250
    assert seen(plan, values) is None
    values[5, 5] = 251
    assert seen(plan, values, photons=False) is None, "what is no count has no count rate"


def test_a_pattern_that_was_not_counted_alone_is_not_too_bright() -> None:
    """A lost edge joins two bins: their sum is no brightness."""
    valid = np.ones(6, bool)
    values = np.array([100.0, 400.0, 100.0, 100.0, 100.0, 100.0])
    assert seen(plan_of(too_bright_s=0), values, valid) is not None
    valid[1] = False
    assert seen(plan_of(too_bright_s=0), values, valid) is None


def test_light_is_gone_below_a_tenth_of_what_it_was() -> None:
    """400 counts in each of eight frames, less 0.05 dark ones: gone below 40.045 - here for two frames, then for three."""
    plan = plan_of(light_gone_s=3 * FRAME_S)
    levels = [400] * 8 + [40, 40, 41, 40, 40, 40, 40]
    stopped = seen(plan, frames_of(*levels))
    assert stopped is not None
    assert (stopped.rule, stopped.pattern) == ("light_gone_s", 14 * 6)
    assert seen(plan, frames_of(*[400] * 7, *[40] * 7)) is None, "seven frames are not yet a light to compare with"
    half = plan_of(light_gone_s=3 * FRAME_S, light_below=0.5)
    assert seen(half, frames_of(*[400] * 8, *[201] * 3)) is None
    assert seen(half, frames_of(*[400] * 8, *[199] * 3)) is not None


def test_a_wild_count_is_no_light_to_compare_with() -> None:
    values = frames_of(*[400] * 30)
    values[60:66] = 1e5
    assert seen(plan_of(light_gone_s=FRAME_S), values) is None


def test_a_run_in_the_dark_has_no_light_from_its_first_frame_on() -> None:
    """0.3 dark counts are expected in a frame: up to 0.3 + 5 sqrt(0.3) + 2 = 5.04 counts are dark, 6 are not."""
    plan = plan_of(light_gone_s=4 * FRAME_S)
    dark = np.zeros((4, 6))
    dark[:, 0] = [5, 0, 3, 1]
    stopped = seen(plan, dark)
    assert stopped is not None
    assert stopped.pattern == 24
    dark[1, 3] = 6
    assert seen(plan, dark) is None
    assert seen(plan, np.zeros((4, 6)), photons=False) is None, (
        "nobody knows the zero of a detector that does not count"
    )


def test_frames_that_were_not_measured_say_nothing_of_the_light() -> None:
    values = frames_of(*[400] * 8, *[np.nan] * 5)
    assert seen(plan_of(light_gone_s=FRAME_S), values, np.isfinite(values)) is None


def test_the_audit_fails_a_frame_for_one_bad_edge() -> None:
    valid = np.ones((10, 6), bool)
    for frame in (2, 3, 4, 6, 7):
        valid[frame, 5] = False
    stopped = seen(plan_of(audit_fails_s=3 * FRAME_S), frames_of(*[9.0] * 10), valid.ravel())
    assert stopped is not None
    assert (stopped.rule, stopped.pattern) == ("audit_fails_s", 30)
    assert seen(plan_of(audit_fails_s=3.01 * FRAME_S), frames_of(*[9.0] * 10), valid.ravel()) is None


@given(st.lists(st.integers(0, 240), max_size=6).map(sorted))
def test_blocks_may_be_cut_anywhere(cuts: list[int]) -> None:
    """The light goes in frame 15 and stays away for ten; blocks end in the middle of frames, or are empty."""
    stopped = seen(plan_of(light_gone_s=10 * FRAME_S), frames_of(*[300] * 15, *[3] * 25), cuts=tuple(cuts))
    assert stopped is not None
    assert stopped.pattern == 25 * 6


def test_blocks_of_a_frame_each_have_a_light_to_compare_with() -> None:
    """Seven frames of the past and the new one are the eight that a light must hold for."""
    values = frames_of(*[300] * 15, *[3] * 25)
    stopped = seen(plan_of(light_gone_s=10 * FRAME_S), values, cuts=tuple(range(6, 240, 6)))
    assert stopped is not None
    assert stopped.pattern == 25 * 6


def test_a_table_without_a_rule_is_none() -> None:
    assert Plan(frames=1, stop_if=StopTable(light_below=0.2)) == Plan(frames=1)
    assert plan_of(light_gone_s=0).stop_if == StopTable(light_gone_s=0)


BRIGHT = 'noise = { kind = "poisson", peak_counts = 4000, seed = 1 }'
DARK = 'object_level = 0.0\nnoise = { kind = "poisson", peak_counts = 400, dark_rate_hz = 600, seed = 1 }'
BAD_LINE = "faults = [" + ", ".join(f'{{ kind = "drop-edge", picture = {k} }}' for k in range(303, 603, 6)) + "]"
RULES = StopTable(too_bright_s=0.01, light_gone_s=0.02, audit_fails_s=0.01)


@pytest.mark.parametrize(
    ("scene", "rule", "pattern", "kept"),
    [
        (BRIGHT, "too_bright_s", 204, 1000),  # 34 frames of 0.3 ms from the first on; blocks of 50 ms
        (DARK, "light_gone_s", 402, 1000),  # 67 frames
        (BAD_LINE, "audit_fails_s", 504, 1000),  # the edge of pattern 303 is missing, in frame 50: 34 from there
    ],
)
def test_a_rule_ends_the_run_safe_and_keeps_what_was_recorded(
    tmp_path: Path, scene: str, rule: str, pattern: int, kept: int
) -> None:
    plan = Plan(frames=1000, image_size=32, superpixel=4, stop_if=RULES)
    ended: list[FinishedEvent] = []
    with Instrument.from_toml(bench_toml(tmp_path, scene)) as bench:
        with pytest.raises(RunStopped, match=f"stop_if.{rule} = .* at pattern {pattern}:") as caught:
            bench.run(
                plan,
                tmp_path / "run.h5",
                listeners=[lambda event: ended.append(event) if isinstance(event, FinishedEvent) else None],
            )
        assert not bench.modulator.running
        assert bench.run(plan.model_copy(update={"stop_if": None, "frames": 10}), tmp_path / "next.h5") is not None
    recording, info = open_recording(tmp_path / "run.h5"), recording_info(tmp_path / "run.h5")
    assert np.isfinite(recording.values).sum() >= 0.9 * kept
    assert len(recording) < 250
    assert (info.state, info.interrupted) == ("interrupted", f"stopped: {caught.value.why}")
    assert recording.timing is not None
    assert recording.timing.verdict in {"partial", "failed"}
    assert f"{recording.timing.patterns_recorded} of 6000 patterns are kept" in caught.value.__notes__[-1]
    assert {c.name: c.outcome for c in check_recording(tmp_path / "run.h5")[0].checks}["checksums"] == "good"
    assert ended[0].outcome == "aborted"


def test_a_rule_that_is_met_with_the_last_pattern_ends_nothing(tmp_path: Path) -> None:
    """The whole run is one block: it is recorded before anybody can stop it."""
    plan = Plan(frames=100, image_size=32, superpixel=4, stop_if=RULES)
    with Instrument.from_toml(bench_toml(tmp_path, BRIGHT)) as bench:
        assert len(bench.run(plan, tmp_path / "run.h5")) == 100


def test_the_command_says_which_rule_it_was_and_check_says_what_may_stop(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    plan = tmp_path / "plan.toml"
    plan.write_text(
        "frames = 1000\nimage_size = 32\nsuperpixel = 4\n[stop_if]\ntoo_bright_s = 0.01\naudit_fails_s = 60\n"
    )
    bench = bench_toml(tmp_path, BRIGHT, counter="edge_times = false")
    assert status(["check", "--bench", str(bench), "--plan", str(plan)]) == 0
    said = " ".join(capsys.readouterr().out.replace("│", " ").split())
    assert "too_bright_s = 0.01, audit_fails_s = 60; audit_fails_s holds for longer than the run lasts" in said
    assert "sees nothing of a counter without edge times" in said
    assert status(["run", "--bench", str(bench), "--plan", str(plan), "--out", str(tmp_path / "run.h5")]) == 4
    assert "stop_if.too_bright_s = 0.01 at pattern 204" in capsys.readouterr().err
