"""What the counts of a run say of themselves: wild ones, shifted ones, exchanged ones, and those that no counter gives."""

import re
from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import numpy as np
import pytest

from instrument import Instrument, Plan, Recording, simulate
from instrument.config import bench_of_tables
from instrument.measurement import Measurement
from instrument.plan import MotionPlan
from protocols import Floats

PLAN = Plan(frames=150, image_size=64)
NOISE = {"kind": "poisson", "peak_counts": 250.0, "seed": 1}


def moving(time_s: Floats) -> Floats:
    return np.stack([250 * time_s, 250 * time_s], axis=1)


def recorded(**scene: object) -> Recording:
    return simulate(PLAN, {"object": "letter-B", "start_px": [22.0, 22.0], "noise": NOISE, **scene}, path=moving)


@pytest.fixture(scope="module")
def clean() -> Recording:
    return recorded()


def measured(recording: Recording, values: Floats) -> Measurement:
    return Measurement.of(replace(recording, values=values))


def assert_none_is_silent(found: Measurement, clean: Recording) -> None:
    """All that is valid is what it was."""
    assert np.array_equal(found.values[found.valid], clean.values[found.valid])


def test_a_good_run_is_left_as_it_is(clean: Recording) -> None:
    found = Measurement.of(clean)
    assert found.findings == ()
    assert found.valid.all()


@pytest.mark.parametrize("factor", [0, 3, 100, 1000])
@pytest.mark.parametrize("column", [1, 3, 4])
def test_a_wild_count_is_masked_and_listed(clean: Recording, column: int, factor: int) -> None:
    """The H+ of frame 77 is bright; a 0 among photons is as wild as a 1000-fold count."""
    values = clean.values.copy()
    values[77, column] *= factor
    found = measured(clean, values)
    assert np.flatnonzero(~found.valid).tolist() == [77]
    assert [(finding.kind, finding.frames) for finding in found.findings] == [("wild counts", (77,))]
    assert f"1 wild count masked: frame 77 column {column}" in found.findings[0].sentence


def test_values_that_come_late_are_moved_back(clean: Recording) -> None:
    """Case: all values one pattern late. The last one is lost."""
    found = measured(clean, np.roll(clean.values.ravel(), 1).reshape(clean.values.shape))
    assert_none_is_silent(found, clean)
    assert found.valid.sum() >= 140
    assert "late by 1 pattern from the first frame on (a sync edge was gained)" in found.findings[0].sentence


@pytest.mark.parametrize(("lost", "gained"), [(10, 200), (10, 30), (300, 601)])
def test_a_bin_lost_and_one_gained_are_found(clean: Recording, lost: int, gained: int) -> None:
    """The totals agree, so that no count of edges tells."""
    bins = clean.values.ravel().tolist()
    bins[gained : gained + 1] = [bins[gained] - 40, 40]
    bins[lost - 1 : lost + 1] = [bins[lost - 1] + bins[lost]]
    found = measured(clean, np.array(bins).reshape(clean.values.shape))
    assert_none_is_silent(found, clean)
    assert found.valid.sum() >= 130
    assert found.findings[0].kind == "shifted patterns"


def test_a_first_edge_that_was_lost_is_told_by_the_timing_report_and_mended(clean: Recording) -> None:
    """With edge times, and as many edges as planned: the audit alone calls it good."""
    late = recorded(faults=[{"kind": "drop-edge", "picture": 0}, {"kind": "surplus-edges", "edges": 1}])
    assert late.timing is not None
    assert late.timing.slipped == ((0, 150, -1),)
    assert late.timing.verdict == "flagged"
    assert any("early by 1 pattern from the first frame on" in note for note in late.timing.notes)
    assert not late.frame_valid.any()
    found = Measurement.of(late)
    assert found.valid.sum() >= 140
    off = np.abs(found.values - clean.values)[found.valid]
    assert off.max() < 6 * np.sqrt(2 * 250)


def test_a_bounce_so_late_that_it_passes_for_the_next_edge_masks_both_frames(clean: Recording) -> None:
    """The last pattern of frame 99 ends after three quarters of its time."""
    cut = recorded(faults=[{"kind": "double-edge", "picture": 599, "after_s": 3.8e-5}])
    assert np.flatnonzero(~cut.frame_valid).tolist() == [99, 100]


def test_what_is_taken_as_its_complement_keeps_the_noise_of_the_counts_that_came() -> None:
    """Photon counts have the variance of the counts: for 30 of 100 that are taken as 70 it is 30."""
    recording = recorded(mirrors_inverted=True)
    found = Measurement.of(recording)
    valid = found.valid
    np.testing.assert_allclose(found.variance[valid, :4], recording.values[valid, :4])
    np.testing.assert_allclose(found.variance[valid, 4], recording.values[valid, 5])


def test_inverted_mirrors_are_seen_of_a_run_that_is_late_from_the_start_too() -> None:
    """The pattern that is all on is in the first frame, near which the shift is not sure."""
    recording = recorded(mirrors_inverted=True)
    late = np.roll(recording.values.ravel(), 1).reshape(recording.values.shape)
    found = measured(recording, late)
    assert [finding.kind for finding in found.findings] == ["shifted patterns", "wiring"]
    assert found.findings[1].frames == (0,)


def test_exchanged_pairs_and_inverted_mirrors_are_told_apart_and_mended(clean: Recording) -> None:
    exchanged = measured(clean, clean.values[:, [0, 1, 2, 3, 5, 4]])
    assert np.array_equal(exchanged.values, clean.values)
    assert "H+/S = 0.00: H- comes first" in exchanged.findings[0].sentence

    inverted = Measurement.of(recorded(mirrors_inverted=True))
    off = np.abs(inverted.values - clean.values)[inverted.valid]
    assert off.max() < 6 * np.sqrt(4 * 250)
    assert inverted.valid.sum() >= 140
    assert "the modulator inverts its pictures" in inverted.findings[0].sentence


def test_counts_that_no_counter_gives_are_told(clean: Recording) -> None:
    values = clean.values.copy()
    values[[5, 6, 7, 8, 9], [1, 2, 3, 0, 4]] = [-3, 7.5, np.nan, np.inf, 1e300]
    found = measured(clean, values)
    assert np.flatnonzero(~found.valid).tolist() == [5, 6, 7, 8, 9]
    kinds = "1 not a number, 1 infinite, 1 beyond 1e+15, 1 negative, 1 not whole"
    assert f"5 impossible counts masked ({kinds})" in found.findings[0].sentence


def test_a_lamp_that_flickers_from_frame_to_frame_is_no_fault() -> None:
    lamp = 1 + 0.05 * np.random.default_rng(1).standard_normal((500, 1))
    values = (50 + 0.1 * np.random.default_rng(0).standard_normal((500, 6))) * lamp
    found = Measurement.of(Recording(Plan(frames=500), values, np.ones(500, np.bool_), 50e-6))
    assert found.findings == ()


def diagonal(time_s: Floats) -> Floats:
    return np.stack([124 * time_s, 120 * time_s], axis=1)


@pytest.fixture(scope="module")
def meeting() -> Recording:
    """On the diagonal the levels of two patterns meet, and late Hadamard values hardly rise above the noise."""
    noise = {"kind": "poisson", "peak_counts": 280.0, "seed": 4}
    scene = {"object": "letter-B", "start_px": [32.4, 31.7], "noise": noise}
    found = simulate(Plan(frames=1666), scene, path=diagonal)
    return replace(found, timing=None, edge_time_s=None)


@pytest.mark.parametrize("by", [1, -1])
def test_a_run_that_is_late_or_early_is_mended_though_levels_meet(meeting: Recording, by: int) -> None:
    found = measured(meeting, np.roll(meeting.values.ravel(), by).reshape(meeting.values.shape))
    assert_none_is_silent(found, meeting)
    assert found.valid.sum() >= 1660
    late = "late by 1 pattern from the first frame on" if by > 0 else "early by 1 pattern from the first frame on"
    assert [late in finding.sentence for finding in found.findings] == [True]


def test_a_lost_bin_is_placed_to_three_patterns_and_mended(meeting: Recording) -> None:
    lost = 5003
    values = np.append(np.delete(meeting.values.ravel(), lost), meeting.values[-1, -1]).reshape(meeting.values.shape)
    found = measured(meeting, values)
    assert found.valid.sum() >= 1655
    assert_none_is_silent(found, meeting)
    told = re.search(r"early by 1 pattern from pattern (\d+) of frame 83[34] on", found.findings[0].sentence)
    assert told is not None
    assert abs(int(told[1]) - lost) <= 3


def test_light_of_the_complements_is_no_slip(meeting: Recording) -> None:
    """S - I of every value: what is bright has little noise then, and what is dark much."""
    total: float = np.median(meeting.values[:, 4:].sum(axis=1))
    complements = np.maximum(np.round(total - meeting.values), 0.0)
    found = measured(meeting, complements)
    assert {finding.kind for finding in found.findings} <= {"wiring", "wild counts"}
    assert found.valid.sum() >= 1660


def test_levels_that_meet_on_a_leaking_bench_are_no_slip() -> None:
    """Where x and y patterns see alike, values could as well be late by three patterns from frame 738 on."""
    noise = {"kind": "poisson", "peak_counts": 250, "seed": 879180331}
    place = (32.153663534863504, 32.8875681785186)
    tables: dict[str, Any] = {role: {"driver": "simulated"} for role in ("modulator", "counter", "stage")}
    tables["scene"] = {"realism": "realistic", "illumination_falloff": 0.0, "start_px": place, "noise": noise}
    with TemporaryDirectory() as folder, Instrument.from_config(bench_of_tables(tables, "the bench")) as bench:
        recording = bench.run(Plan(frames=1666, motion=MotionPlan(velocity_mm_s=25)), Path(folder) / "run.h5")
    found = Measurement.of(replace(recording, timing=None, edge_time_s=None))
    assert {finding.kind for finding in found.findings} <= {"wild counts"}
    assert np.count_nonzero(found.valid) >= 1660


@pytest.mark.parametrize("frames", [1, 2, 3, 5, 10])
def test_few_frames_are_no_fault(clean: Recording, frames: int) -> None:
    assert Measurement.of(clean.first(frames)).findings == ()
