"""Patterns in the wrong place, and bins that are lost or added."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest

from instrument import Plan, simulate
from protocols import Floats
from sim_backends.bench.settings import SwappedPatterns
from sim_backends.bench.wiring import wired
from tests.sim_backends.projector import SIZE, bench_with, pixel, save, show

ORDER = np.array([10, 11, 12, 13, 14, 15, 20, 21, 22, 23, 24, 25, 99])
"""Two frames of six and the guard."""


def test_a_right_wiring_changes_nothing() -> None:
    assert wired(ORDER, None, 0).tolist() == ORDER.tolist()


def test_the_hadamard_pattern_and_its_complement_change_places_in_every_frame() -> None:
    seen = wired(ORDER, SwappedPatterns(), 0)
    assert seen.tolist() == [10, 11, 12, 13, 15, 14, 20, 21, 22, 23, 25, 24, 99]
    other = wired(ORDER, SwappedPatterns(patterns_per_frame=4, first=0, second=3), 0)
    assert other.tolist() == [13, 11, 12, 10, 21, 15, 20, 14, 25, 23, 24, 22, 99]


def test_a_frame_that_is_not_whole_keeps_its_order() -> None:
    assert wired(np.array([1, 2, 3, 4, 99]), SwappedPatterns(patterns_per_frame=3, first=0, second=1), 0).tolist() == [
        2, 1, 3, 4, 99,
    ]  # fmt: skip


def test_patterns_that_come_late_begin_with_the_guard_and_early_ones_end_with_it() -> None:
    assert wired(ORDER[6:], None, 1).tolist() == [99, 20, 21, 22, 23, 24, 25]
    assert wired(ORDER[6:], None, -2).tolist() == [22, 23, 24, 25, 99, 99, 99]
    assert wired(ORDER[6:], None, 1000).tolist() == [99] * 7


def test_the_bench_counts_what_is_really_shown(tmp_path: Path) -> None:
    """A scene whose pixel (0, k) lets k / 10 through: pattern k gives k / 10."""
    cells = np.zeros((SIZE, SIZE))
    cells[0, :10] = np.arange(10) / 10
    scene = {"object": save(tmp_path, cells)}
    swapped = bench_with(tmp_path, **scene, swap={"patterns_per_frame": 3, "first": 1, "second": 2}, patterns_late=1)
    show(swapped, [pixel(0, k) for k in range(1, 7)])
    assert swapped.counts(0, 6).tolist() == pytest.approx([0.0, 0.1, 0.3, 0.2, 0.4, 0.6])


# Bins lost or added, by faults of the sync line. The counter gives no edge times.

PLAN = Plan(frames=40, motion=None)
STILL = {"noise": {"kind": "none"}}


def _values(tmp_path: Path, *faults: Mapping[str, object]) -> Floats:
    """Values of 240 bins at the counter, read from the bench: what a counter without edge times hands over."""
    cells = np.zeros((SIZE, SIZE))
    cells[0, :] = np.arange(SIZE) / 100
    bench = bench_with(tmp_path, object=save(tmp_path, cells), faults=list(faults))
    show(bench, [pixel(0, k) for k in range(1, 16)])
    n = len(bench.edges(0, 1.0)) - 1
    return bench.counts(0, n).astype(np.float64) * 100


def test_a_lost_edge_loses_a_bin_and_moves_all_after_it(tmp_path: Path) -> None:
    """Pattern k gives k: bins 5 and 6 become one, of 5 + 6."""
    seen = _values(tmp_path, {"kind": "drop-edge", "picture": 5})
    assert seen.tolist() == pytest.approx([1, 2, 3, 4, 11, 7, 8, 9, 10, 11, 12, 13, 14, 15])


def test_a_bounced_edge_adds_a_bin_and_moves_all_after_it(tmp_path: Path) -> None:
    seen = _values(tmp_path, {"kind": "double-edge", "picture": 5, "after_s": 10e-6})
    assert seen.tolist() == pytest.approx([1, 2, 3, 4, 5, 1.2, 4.8, *range(7, 16)])


def test_both_together_leave_the_number_of_bins_and_only_what_is_between_them_slips(tmp_path: Path) -> None:
    """No count of edges can tell: 15 bins."""
    faults = [{"kind": "drop-edge", "picture": 3}, {"kind": "double-edge", "picture": 10, "after_s": 10e-6}]
    seen = _values(tmp_path, *faults)
    assert seen.tolist() == pytest.approx([1, 2, 7, 5, 6, 7, 8, 9, 10, 2.2, 8.8, 12, 13, 14, 15])


def test_a_first_edge_lost_and_one_too_many_move_the_whole_run_by_one(tmp_path: Path) -> None:
    seen = _values(tmp_path, {"kind": "drop-edge", "picture": 0}, {"kind": "surplus-edges", "edges": 1})
    assert seen.tolist() == pytest.approx([*range(2, 16), 0])


def test_wrong_wiring_goes_through_the_whole_instrument() -> None:
    """Swapped: values 4 and 5 of every frame change places, nothing else does. Late by one: every value is the next one's."""
    right = simulate(PLAN, STILL).values
    swapped = simulate(PLAN, {**STILL, "swap": {}}).values
    assert swapped[:, [0, 1, 2, 3, 5, 4]].tolist() == right.tolist()
    late = simulate(PLAN, {**STILL, "patterns_late": 1}).values
    assert late.ravel()[1:].tolist() == pytest.approx(right.ravel()[:-1].tolist())
    assert late[0, 0] == 0.0
    inverted = simulate(PLAN, {**STILL, "mirrors_inverted": True}).values
    assert inverted[0, 4] == 0.0  # the first Hadamard pattern is all on
    assert inverted + right == pytest.approx(np.full_like(right, right[0, 4]))
