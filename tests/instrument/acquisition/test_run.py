"""One run on scripted devices: what is asked of them, in which order, how long it waits, and what it trusts when it breaks."""

import pytest

from instrument.acquisition import Outcome, acquire, prepare
from instrument.plan import MotionPlan, Plan
from instrument.schemes import scheme_of
from protocols import CounterOverrun, ModulatorTiming, TimingFault, TriggerMissed
from tests.instrument.acquisition.scripted import PERIOD_S, Bench, bins

RESTING = Plan(frames=4, image_size=8)
MOVING = RESTING.model_copy(update={"motion": MotionPlan(velocity_mm_s=25.0, acceleration_mm_s2=250.0)})
TIMING = ModulatorTiming(picture_time_us=50)


def acquired(bench: Bench, plan: Plan = RESTING, patterns: int = 24) -> Outcome:
    return acquire(plan, TIMING, bench.devices, bench.host, patterns=patterns, patterns_per_frame=6)


def test_preparing_loads_first_and_goes_to_the_start_then() -> None:
    """4 frames show the 4 fringes and 4 pairs, of which the complement of the all-one pattern is the guard."""
    bench = Bench()
    timing = prepare(MOVING, scheme_of(MOVING).sequence(64, 64), bench.devices, bench.host)
    assert timing.picture_time_us == 52, "what the modulator keeps, and not what it was asked for"
    assert bench.log == [
        "uploading",
        "load 12 at 50 us",
        "uploaded 1 of 12",
        "positioning",
        "to 0 at 25 mm/s",
        "at 0",
    ]


def test_preparing_a_plan_without_motion_leaves_the_stage_alone() -> None:
    bench = Bench()
    prepare(RESTING, scheme_of(RESTING).sequence(64, 64), bench.devices, bench.host)
    assert bench.log == ["uploading", "load 12 at 50 us", "uploaded 1 of 12"]


def test_a_good_run_arms_before_it_moves_and_moves_before_it_shows() -> None:
    """The stage runs 24 x 50 us at 25 mm/s, twice 0.1 s of settling and two ramps of 1.25 mm: 7.53 mm."""
    bench = Bench(bins(0, 10), bins(10, 14))
    outcome = acquired(bench, MOVING)
    assert bench.log == [
        *(
            "arming",
            "arm",
            "running up",
            "to 7.53 at 25 mm/s",
            "counting",
            "start",
            "coming to rest",
            "wait",
            "at 7.53",
        ),
        "disarm",
    ]
    assert outcome.error is None
    assert outcome.report.verdict == "good"
    assert outcome.frame_valid.tolist() == [True] * 4
    assert outcome.motion is not None
    assert outcome.motion.target_mm == pytest.approx(7.53)
    assert [block.first_pattern for block in bench.host.placed_blocks] == [0, 10]


def test_the_run_up_is_slept_in_short_naps_with_a_look_between_them() -> None:
    """A ramp of 25 / 250 s and 0.1 s to settle are four naps of 50 ms."""
    bench = Bench(bins(0, 24))
    acquired(bench, MOVING)
    assert bench.clock.pauses_s == pytest.approx([0.05] * 4)
    assert bench.host.checkpoints == 4 + 1 + 1, "one a nap, one after the start, one a block"


def test_the_last_nap_is_no_longer_than_what_is_left() -> None:
    plan = RESTING.model_copy(
        update={"motion": MotionPlan(velocity_mm_s=25.0, acceleration_mm_s2=250.0, settle_s=0.02)}
    )
    bench = Bench(bins(0, 24))
    acquired(bench, plan)
    assert bench.clock.pauses_s == pytest.approx([0.05, 0.05, 0.02])


def test_only_the_first_edge_is_waited_for_longer() -> None:
    """0.05 s of latency, 0.2 s of margin and 100 periods of 50 us; one second more for the first picture.

    Of later ones the 0.2 s are kept for a second look, after one at the modulator.
    """
    bench = Bench(bins(0, 6), bins(6, 6), bins(12, 12))
    acquired(bench)
    assert bench.counter.timeouts_s == pytest.approx([1.255, 0.055, 0.055])
    assert bench.modulator.waited_s == pytest.approx(0.205)


@pytest.mark.parametrize(("patterns", "most", "asked"), [(24, None, 40), (600, None, 622), (24, 30, 30), (24, 50, 40)])
def test_the_counter_has_room_for_bins_that_surplus_edges_split(patterns: int, most: int | None, asked: int) -> None:
    """One in a hundred, and 16 more; never beyond what the counter can count."""
    bench = Bench()
    limits = bench.counter.limits.model_copy(update={"max_bins": most})
    bench.counter.limits = limits
    acquired(bench, patterns=patterns)
    assert bench.counter.armed is not None
    assert bench.counter.armed.n_bins == asked
    assert bench.counter.armed.period_s == pytest.approx(PERIOD_S)


def test_a_stall_keeps_what_came_before_where_edges_were_timed() -> None:
    bench = Bench(bins(0, 15))
    bench.modulator.playing = True
    outcome = acquired(bench)
    assert isinstance(outcome.error, TriggerMissed)
    assert (outcome.error.bins_read, outcome.error.bins_expected) == (15, 24)
    assert "then no sync edge for 0.255 s" in outcome.error.saw
    assert outcome.frame_valid.tolist() == [True, True, False]
    assert outcome.report.verdict == "partial"
    assert bench.log[-2:] == ["broke", "disarm"]
    assert not any("no frame can be trusted" in note for note in outcome.report.notes)


@pytest.mark.parametrize(("timed", "playing", "sure"), [(True, True, True), (True, False, False), (False, True, False)])
def test_a_missing_edge_is_sure_only_where_it_was_timed_and_pictures_still_came(
    *, timed: bool, playing: bool, sure: bool
) -> None:
    """Where all pictures were played, or no edge was timed, any of them may be the lost one."""
    bench = Bench(bins(0, 15, timed=timed))
    bench.modulator.playing = playing
    outcome = acquired(bench)
    assert outcome.frame_valid.tolist() == ([True, True, False] if sure else [False] * 3)
    doubt = "no frame can be trusted: 9 sync edges are missing and nothing tells which"
    assert (doubt in outcome.report.notes) is not sure


def test_a_modulator_that_does_not_answer_broke_off_as_well() -> None:
    bench = Bench(bins(0, 15))
    bench.modulator.broken = True
    assert acquired(bench).frame_valid.tolist() == [True, True, False]


def test_an_error_that_is_no_missing_edge_casts_no_doubt_on_what_came() -> None:
    """Ended on request after the second block, without edge times: the frames so far are good."""
    bench = Bench(bins(0, 6, timed=False), bins(6, 6, timed=False), bins(12, 12, timed=False), end_at=3)
    outcome = acquired(bench)
    assert isinstance(outcome.error, InterruptedError)
    assert outcome.frame_valid.tolist() == [True, True]
    assert bench.log[-2:] == ["broke", "disarm"]


def test_a_counter_that_is_full_of_bounces_is_no_missing_edge() -> None:
    """Forty bins, each but the first a bounce: the room is used up, and only one pattern has come."""
    bench = Bench(bins(0, 40, timed=False))
    outcome = acquired(bench, patterns=24)
    assert outcome.error is None
    assert outcome.report.patterns_recorded == 24

    bounces = bins(0, 40)
    assert bounces.opening_edge_s is not None
    bounces.opening_edge_s[1:] = PERIOD_S + bounces.opening_edge_s[1:] * 1e-3
    object.__setattr__(bounces, "closing_edge_s", PERIOD_S * 1.2)
    outcome = acquired(Bench(bounces))
    assert type(outcome.error) is TimingFault
    assert "saw 40 bins that make only 1 of 24 patterns" in str(outcome.error)


def test_a_block_that_was_lost_is_told_apart_from_edges_that_never_came() -> None:
    outcome = acquired(Bench(bins(0, 6), bins(12, 6)))
    assert isinstance(outcome.error, CounterOverrun)
    assert "bins 6 to 11 are missing" in str(outcome.error)
    assert outcome.frame_valid.tolist() == [True]


def test_a_counter_that_cannot_be_disarmed_leaves_the_counts_and_a_note() -> None:
    bench = Bench(bins(0, 24))
    bench.counter.disarms_with = OSError("the cable is out")
    outcome = acquired(bench)
    assert isinstance(outcome.error, OSError)
    assert outcome.frame_valid.tolist() == [True] * 4
    assert outcome.report.notes == ("the cable is out",)
    assert outcome.report.bins_received == 24


def test_of_two_errors_the_first_one_is_told() -> None:
    bench = Bench(bins(0, 6), bins(12, 6))
    bench.counter.disarms_with = OSError("the cable is out")
    assert isinstance(acquired(bench).error, CounterOverrun)


def test_devices_that_a_script_has_opened_are_closed_the_last_first() -> None:
    bench = Bench()
    with bench.devices.closing:
        pass
    assert bench.log == ["close stage", "close pmt", "close dmd"]
    assert [role.name for role in bench.devices.roles()] == ["modulator", "counter", "stage"]
    assert bench.devices.identities()["counter"].name == "pmt"
