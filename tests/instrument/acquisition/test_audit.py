"""The audit's figures, from edges written by hand."""

import numpy as np
import pytest

from instrument.acquisition import AlignedBlock, Aligner, TimingAudit, TimingReport
from protocols import CountBlock, CounterReport, Counts, Floats

PERIOD_S = 50e-6


def periods(edges: int) -> Floats:
    return np.arange(edges, dtype=np.float64) * PERIOD_S


def audited(edges: Floats, counts: Counts, *, patterns: int, edges_seen: int | None = None) -> TimingReport:
    audit = TimingAudit(patterns=patterns, patterns_per_frame=6, picture_time_s=PERIOD_S, max_count_rate_hz=5e6)
    placed = Aligner(PERIOD_S, patterns).place(CountBlock(0, counts, edges[:-1], float(edges[-1])))
    audit.see(placed, bins=len(counts), photon_counts=counts.dtype == np.uint32)
    told = CounterReport(bins_closed=len(counts), edges_seen=edges_seen)
    return audit.report(told)


def test_a_perfect_run_is_good() -> None:
    report = audited(periods(13), np.ones(12), patterns=12, edges_seen=13)
    assert report.verdict == "good"
    assert (report.patterns_recorded, report.frames, report.frames_masked) == (12, 2, 0)
    assert report.surplus_edges == 0
    assert report.mean_period_s == pytest.approx(PERIOD_S)
    assert report.jitter_s == pytest.approx(0, abs=1e-12)


def test_jitter_is_the_standard_deviation_of_the_steps() -> None:
    """Edges at 0, T + d, 2T, 3T + d, ...: steps alternate between T + d and T - d, so their deviation is d."""
    edges = periods(13)
    edges[1::2] += 100e-9
    report = audited(edges, np.ones(12), patterns=12)
    assert report.jitter_s == pytest.approx(100e-9, rel=0.01)
    assert "edge jitter is 100 ns, above 50 ns: bins differ in length by that much" in report.notes


def test_a_clock_offset_is_stated_in_ppm() -> None:
    report = audited(periods(601) * (1 + 150e-6), np.ones(600), patterns=600)
    assert report.clock_offset_ppm == pytest.approx(150, rel=1e-3)
    assert any("+150 ppm" in note for note in report.notes)


def test_a_lost_edge_masks_one_frame_and_names_the_pattern() -> None:
    edges = np.delete(periods(19), 8)
    report = audited(edges, np.ones(17), patterns=18)
    assert report.verdict == "flagged"
    assert report.gaps == (8,)
    assert (report.frames, report.frames_masked, report.bins_received) == (3, 1, 17)


def test_a_run_that_ends_early_is_partial_and_keeps_its_whole_frames() -> None:
    report = audited(periods(10), np.ones(9), patterns=18)
    assert report.verdict == "partial"
    assert report.frames == 1


def test_edges_after_the_run_are_counted() -> None:
    report = audited(periods(13), np.ones(12), patterns=12, edges_seen=16)
    assert report.surplus_edges == 3
    assert any("3 sync edges after the run" in note and "every pattern is displaced" in note for note in report.notes)


def test_patterns_above_the_linear_limit_are_counted() -> None:
    """5e6 counts/s in 50 us are 250 counts."""
    counts = np.array([250, 251, 300, 1, 1, 1], np.uint32)
    report = audited(periods(7), counts, patterns=6)
    assert report.nonlinear_patterns == 2
    assert report.brightest_rate_hz == pytest.approx(6e6)


def untimed(counts: Counts, *, patterns: int, edges_seen: int, shifted: bool = False) -> TimingReport:
    audit = TimingAudit(patterns=patterns, patterns_per_frame=6, picture_time_s=PERIOD_S, max_count_rate_hz=5e6)
    audit.see(Aligner(PERIOD_S, patterns).place(CountBlock(0, counts)), bins=len(counts), photon_counts=True)
    told = CounterReport(bins_closed=len(counts), edges_seen=edges_seen, shifted=shifted)
    report = audit.report(told)
    assert audit.report(told) == report  # asking changes nothing
    assert audit.frame_valid(told).tolist() == [report.verdict == "good"] * report.frames
    return report


def test_surplus_edges_that_came_as_bins_are_surplus_too() -> None:
    """12 patterns need 13 edges; 16 edges gave 15 bins, of which the last three lie beyond the run."""
    assert audited(periods(16), np.ones(15), patterns=12, edges_seen=16).surplus_edges == 3


def test_without_edge_times_a_surplus_edge_may_be_anywhere() -> None:
    """14 edges where 13 are due: a bounce in the middle moves all later bins, one after the end does no harm. Who can tell?"""
    light = np.ones(13, np.uint32)
    assert untimed(light[:12], patterns=12, edges_seen=13).verdict == "good"
    report = untimed(light, patterns=12, edges_seen=14)
    assert (report.verdict, report.frames_masked) == ("failed", 2)
    assert any("1 surplus sync edges and no edge times" in note for note in report.notes)


def test_bins_that_a_counter_calls_shifted_are_not_trusted() -> None:
    report = untimed(np.ones(12, np.uint32), patterns=12, edges_seen=13, shifted=True)
    assert (report.verdict, report.frames_masked) == ("failed", 2)


def test_a_run_without_a_single_photon_has_failed() -> None:
    report = untimed(np.zeros(12, np.uint32), patterns=12, edges_seen=13)
    assert report.verdict == "failed"
    assert any("not one photon" in note for note in report.notes)


def test_asking_twice_gives_the_same_report() -> None:
    """Two doubts, neither of them told twice, and the mask as before."""
    audit = TimingAudit(patterns=12, patterns_per_frame=6, picture_time_s=PERIOD_S, max_count_rate_hz=5e6)
    audit.see(Aligner(PERIOD_S, 12).place(CountBlock(0, np.zeros(12, np.uint32))), bins=12, photon_counts=True)
    shifted = CounterReport(bins_closed=12, shifted=True)
    first = audit.report(shifted)
    assert audit.report(shifted) == first
    assert len(first.notes) == 2
    good = CounterReport(bins_closed=12, edges_seen=13)
    assert len(audit.report(good).notes) == 1  # what one counter told does not stick


def test_of_many_notes_of_a_counter_the_first_are_kept() -> None:
    audit = TimingAudit(patterns=6, patterns_per_frame=6, picture_time_s=PERIOD_S, max_count_rate_hz=5e6)
    audit.see(Aligner(PERIOD_S, 6).place(CountBlock(0, np.ones(6))), bins=6, photon_counts=False)
    told = CounterReport(bins_closed=6, notes=tuple(f"packet {k} was lost" for k in range(60)))
    notes = audit.report(told).notes
    assert len(notes) == 51
    assert notes[-1] == "10 more notes of the counter are left out"


def told_by(*edges: Floats) -> TimingReport:
    """Audit of blocks of six bins whose opening edges are these, as the aligner would give them."""
    audit = TimingAudit(patterns=6 * len(edges), patterns_per_frame=6, picture_time_s=PERIOD_S, max_count_rate_hz=5e6)
    none = np.zeros(0, np.int64)
    for k, opening in enumerate(edges):
        audit.see(
            AlignedBlock(6 * k, np.ones(6), np.ones(6, bool), opening, none, none, none), bins=6, photon_counts=False
        )
    return audit.report(CounterReport(bins_closed=6 * len(edges)))


def test_edge_times_that_are_no_numbers_or_go_back_make_every_frame_doubtful() -> None:
    good = periods(12)
    assert told_by(good[:6], good[6:]).verdict == "good"
    for place in (0, 5, 8):
        broken = good.copy()
        broken[place] = np.nan
        report = told_by(broken[:6], broken[6:])
        assert (report.verdict, report.frames_masked) == ("failed", 2)
        assert "no frame can be trusted: the counter gave edge times that are no numbers" in report.notes
    for blocks in ((good[:6], good[:6]), (good[:6][::-1], good[6:]), (good[:6], good[6:] - 2 * PERIOD_S)):
        report = told_by(*blocks)
        assert (report.verdict, report.frames_masked) == ("failed", 2)
        assert "no frame can be trusted: the counter gave edge times that go back" in report.notes


def test_a_run_that_ended_early_is_partial_and_counts_its_good_frames() -> None:
    """15 of 24 patterns: two whole frames, of which a lost edge spoils the second."""
    whole = audited(periods(16), np.ones(15), patterns=24)
    assert (whole.verdict, whole.frames, whole.frames_masked) == ("partial", 2, 0)
    assert "the run ended early; 2 of its 4 frames are good" in whole.notes
    spoilt = audited(np.delete(periods(16), 8), np.ones(14), patterns=24)
    assert (spoilt.verdict, spoilt.frames_masked) == ("partial", 1)
    assert "the run ended early; 1 of its 4 frames are good" in spoilt.notes
