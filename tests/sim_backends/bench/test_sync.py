"""Sync edges and their faults."""

import numpy as np
import pytest

from sim_backends.bench.fault_settings import DoubledEdge, DroppedEdge, Fault, Stall, SurplusEdges
from sim_backends.bench.sync import overlap, sync_line


def phases(*faults: Fault) -> list[float]:
    return [float(phase) for phase in sync_line(5, picture_time_s=50e-6, faults=faults).phase]


def test_a_perfect_line_has_one_edge_at_the_start_of_each_picture() -> None:
    assert phases() == [0.0, 1.0, 2.0, 3.0, 4.0]


def test_a_sync_delay_puts_each_edge_before_its_picture() -> None:
    assert sync_line(3, picture_time_s=50e-6, delay_s=10e-6).phase.tolist() == pytest.approx([-0.2, 0.8, 1.8])


def test_a_dropped_edge_is_missing() -> None:
    assert phases(DroppedEdge(kind="drop-edge", picture=2)) == [0.0, 1.0, 3.0, 4.0]


def test_a_doubled_edge_comes_twice() -> None:
    assert phases(DoubledEdge(kind="double-edge", picture=2, after_s=5e-6)) == pytest.approx([0, 1, 2, 2.1, 3, 4])


def test_after_a_stall_no_edge_comes() -> None:
    line = sync_line(
        5, picture_time_s=50e-6, faults=(Stall(kind="stall", picture=2), SurplusEdges(kind="surplus-edges"))
    )
    assert line.phase.tolist() == [0.0, 1.0, 2.0]
    assert line.stalls_at == 2


def test_surplus_edges_follow_the_guard_picture() -> None:
    assert phases(SurplusEdges(kind="surplus-edges", edges=2)) == [0, 1, 2, 3, 4, 5, 6]


def test_a_fault_at_a_picture_that_is_never_shown_does_nothing() -> None:
    faults: tuple[Fault, ...] = (
        DroppedEdge(kind="drop-edge", picture=5),
        DoubledEdge(kind="double-edge", picture=5),
        DoubledEdge(kind="double-edge", picture=9),
        Stall(kind="stall", picture=5),
    )
    assert phases(*faults) == [0.0, 1.0, 2.0, 3.0, 4.0]


def test_jitter_has_the_width_that_was_asked_for_and_repeats_with_its_seed() -> None:
    first = sync_line(20_000, picture_time_s=50e-6, jitter_s=100e-9, seed=4).phase
    jitter_s = (first - np.arange(20_000)) * 50e-6
    assert jitter_s.std() == pytest.approx(100e-9, rel=0.02)
    assert (first == sync_line(20_000, picture_time_s=50e-6, jitter_s=100e-9, seed=4).phase).all()
    assert (first != sync_line(20_000, picture_time_s=50e-6, jitter_s=100e-9, seed=5).phase).any()


def test_edges_that_jitter_changes_places_with_come_in_order() -> None:
    phase = sync_line(20_000, picture_time_s=50e-6, jitter_s=100e-6, seed=4).phase
    assert (np.diff(phase) >= 0).all()


def test_a_bin_gathers_the_pictures_between_its_edges_by_their_part() -> None:
    light = np.array([10.0, 20.0, 40.0])
    begin, end = np.array([0.0, 0.5, 0.0, 1.25, 2.5, -1.0]), np.array([1.0, 1.5, 3.0, 1.5, 4.0, 0.1])
    assert overlap(begin, end, 0, light) == pytest.approx([10.0, 15.0, 70.0, 5.0, 20.0, 1.0])


def test_whole_pictures_are_gathered_without_rounding() -> None:
    light = np.random.default_rng(0).random(1000)
    edges = np.arange(1001.0)
    assert (overlap(edges[:-1], edges[1:], 0, light) == light).all()
