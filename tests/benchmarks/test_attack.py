"""The short form of the attack: each road a few times, nothing bad, and a harness that would see it."""

import sys
from dataclasses import dataclass, replace

import numpy as np
import pytest

from benchmarks import attack
from benchmarks.attack import ROADS, attacked, line_of
from benchmarks.attack_commands import signals
from benchmarks.attack_faults import PLAN, faults, recorded, wrong_frames
from instrument.session import simulate

linux = pytest.mark.skipif(sys.platform != "linux", reason="the attacks on processes look into /proc")


@linux
@pytest.mark.parametrize("road", ["two writers", "hostile inputs"])
def test_a_short_attack_finds_nothing(road: str) -> None:
    (line,) = attacked([road], 3, short=True, seconds=60.0)
    assert line.bad == 0, line.worst
    assert line.tried == ROADS[road][1]


@linux
def test_signals_at_random_moments_find_nothing() -> None:
    """One is enough here: every moment by itself is in the tests of the command."""
    (row,) = signals(1, 2)
    assert row.good, row.wrong
    assert row.took_s < 10.0


@pytest.mark.parametrize("edge_times", [True, False])
@pytest.mark.parametrize("at_once", [1, 3])
def test_a_few_faults_give_no_frame_that_is_wrong_in_silence(at_once: int, *, edge_times: bool) -> None:
    rows = faults(6, 4, at_once=at_once, edge_times=edge_times)
    assert [row for row in rows if not row.good] == []


def test_frames_that_are_shifted_or_wrong_are_seen_and_masked_ones_are_not_counted() -> None:
    """Of the photons of another seed none is farther off than 8 standard deviations."""
    clean = simulate(PLAN, {"noise": {"kind": "poisson", "peak_counts": 2000, "seed": 9}})
    assert wrong_frames(clean) == 0
    shifted = replace(clean, values=np.roll(clean.values.ravel(), 1).reshape(clean.values.shape))
    assert wrong_frames(shifted) == PLAN.frames
    masked = replace(shifted, frame_valid=np.arange(PLAN.frames) < 3)
    assert wrong_frames(masked) == 3
    values = clean.values.copy()
    values[7, 2] += 1000
    assert wrong_frames(replace(clean, values=values)) == 1


@dataclass(frozen=True)
class Told:
    good: bool
    doubtful: bool = False


def test_the_table_counts_what_went_wrong_and_lets_nothing_through_that_was_not_told() -> None:
    rows = [Told(good=True)] * 5 + [Told(good=False, doubtful=True)] * 2
    line = line_of("road", rows, 3, 1.0)
    assert (line.tried, line.bad, line.met) == (7, 2, True)
    assert not line_of("road", [*rows, Told(good=False)], 3, 1.0).met
    assert not line_of("road", [Told(good=False, doubtful=True)] * 4, 3, 1.0).met
    assert not line_of("road", [], 3, 1.0).met
    assert next(attacked(["signals"], 1, short=True, seconds=-1.0)).worst == "not tried: the time was over"


def test_what_took_too_much_memory_is_not_met() -> None:
    line = line_of("road", [Told(good=True)], 0, 1.0)
    assert 0.05 < line.most_gb < 2.0
    assert line.met
    assert not replace(line, most_gb=2.1).met


def test_a_road_whose_module_is_not_there_is_not_tried_and_not_met() -> None:
    assert attack.elsewhere("attack_by_nobody", "function")(3, 1) == []


@pytest.mark.parametrize("stall", [16, 34])
def test_where_edges_are_missing_and_too_few_frames_tell_whether_the_first_is_none_is_trusted(stall: int) -> None:
    """The first edge lost, and the sync line dead after some frames: all values come one pattern early."""
    lost = [{"kind": "drop-edge", "picture": 0}]
    recording, _ = recorded([*lost, {"kind": "stall", "picture": stall}], edge_times=True)
    assert recording is not None
    assert wrong_frames(recording) == 0
    assert not recording.frame_valid.any()
    assert recording.timing is not None
    assert recording.timing.verdict == "failed"
    assert any("too few frames tell whether the first was lost" in note for note in recording.timing.notes)


def test_a_longer_run_that_stalls_keeps_its_frames_as_the_values_vouch_for_the_first_edge() -> None:
    recording, _ = recorded([{"kind": "stall", "picture": 100}], edge_times=True)
    assert recording is not None
    assert recording.timing is not None
    assert (recording.timing.verdict, int(recording.frame_valid.sum())) == ("partial", 16)
    late, _ = recorded([{"kind": "drop-edge", "picture": 0}, {"kind": "stall", "picture": 100}], edge_times=True)
    assert late is not None
    assert late.timing is not None
    assert not late.frame_valid.any()
    assert late.timing.slipped == ((0, 16, -1),)
