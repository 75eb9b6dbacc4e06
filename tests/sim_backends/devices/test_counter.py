"""The simulated counter: bins between edges, in hardware order, on the bench's time."""

import numpy as np
import pytest

from protocols import (
    BenchContext,
    CountBlock,
    CounterOverrun,
    CounterRun,
    DeviceDisconnected,
    PhotonCounter,
    PlanError,
    WrongState,
)
from sim_backends.bench import OpticalBench
from sim_backends.devices.counter import CounterSettings, SimulatedCounter, plugin
from tests.sim_backends.projector import PICTURE_S, all_on, bench_with, show

RUN = CounterRun(n_bins=10, period_s=PICTURE_S, latency_s=4 * PICTURE_S)


def pmt(bench: OpticalBench, **settings: object) -> SimulatedCounter:
    return plugin.open(CounterSettings.model_validate(settings), BenchContext(clock=bench.clock, scene=bench))


def square_bench(**scene: object) -> OpticalBench:
    """A bench on which an all-lit picture gives 4."""
    return bench_with(object="square", object_height_px=2, **scene)


def read_all(counter: SimulatedCounter, timeout_s: float = 1.0) -> list[CountBlock]:
    blocks: list[CountBlock] = []
    while len(block := counter.read(timeout_s)):
        blocks.append(block)
    return blocks


def test_it_is_a_counter_that_says_it_is_simulated() -> None:
    counter = pmt(bench_with())
    assert isinstance(counter, PhotonCounter)
    assert counter.identity.name == "pmt"
    assert counter.identity.simulated


def test_its_limits_are_those_of_the_head_and_of_the_scene() -> None:
    limits = pmt(bench_with(noise={"kind": "poisson", "dead_time_s": 20e-9, "dark_rate_hz": 600})).limits
    assert limits.max_count_rate_hz == 5e6
    assert (limits.dead_time_s, limits.dark_rate_hz) == (20e-9, 600.0)
    assert limits.edge_time_resolution_s == 1e-8
    assert pmt(bench_with()).limits.dead_time_s == 0.0
    wrong = pmt(bench_with(), dead_time_s=30e-9, dark_rate_hz=50.0, edge_times=False).limits
    assert (wrong.dead_time_s, wrong.dark_rate_hz, wrong.edge_time_resolution_s) == (30e-9, 50.0, None)


def test_n_bins_come_from_n_plus_one_edges_in_blocks_of_the_latency() -> None:
    bench = square_bench()
    counter = pmt(bench)
    counter.arm(RUN)
    show(bench, [all_on()] * 10)
    blocks = read_all(counter)
    assert [(block.first_bin, len(block)) for block in blocks] == [(0, 4), (4, 4), (8, 2)]
    assert np.concatenate([block.counts for block in blocks]).tolist() == [4.0] * 10
    assert bench.clock.now_s() == pytest.approx(10 * PICTURE_S)
    report = counter.disarm()
    assert (report.bins_closed, report.edges_seen) == (10, 11)


def test_a_read_passes_only_the_time_that_its_bins_need() -> None:
    bench = square_bench()
    counter = pmt(bench)
    counter.arm(RUN)
    show(bench, [all_on()] * 10, start_s=1.0)
    counter.read(5.0)
    assert bench.clock.now_s() == pytest.approx(1.0 + 4 * PICTURE_S)


def test_a_read_that_times_out_hands_over_what_has_closed() -> None:
    bench = square_bench()
    counter = pmt(bench)
    counter.arm(RUN)
    show(bench, [all_on()] * 10)
    assert len(counter.read(2.5 * PICTURE_S)) == 2
    assert bench.clock.now_s() == pytest.approx(2.5 * PICTURE_S)


def test_before_the_first_edge_a_read_is_empty() -> None:
    bench = square_bench()
    counter = pmt(bench)
    counter.arm(RUN)
    block = counter.read(0.25)
    assert len(block) == 0
    assert block.closing_edge_s is None
    assert bench.clock.now_s() == 0.25
    show(bench, [all_on()] * 10, start_s=2.0)
    assert len(counter.read(0.5)) == 0
    assert len(counter.read(2.0)) == 4


def test_after_its_last_bin_a_read_returns_at_once() -> None:
    bench = square_bench()
    counter = pmt(bench)
    counter.arm(RUN)
    show(bench, [all_on()] * 20)
    read_all(counter)
    now_s = bench.clock.now_s()
    assert len(counter.read(100.0)) == 0
    assert bench.clock.now_s() == now_s


def test_edge_times_are_whole_ticks_from_the_first_edge() -> None:
    bench = square_bench(sync_jitter_s=1e-7)
    counter = pmt(bench, edge_time_resolution_s=1e-8)
    counter.arm(RUN)
    show(bench, [all_on()] * 10, start_s=0.5)
    first, second, _ = read_all(counter)
    assert first.opening_edge_s is not None
    assert second.opening_edge_s is not None
    assert first.opening_edge_s[0] == 0.0
    assert first.closing_edge_s == second.opening_edge_s[0]
    ticks = first.opening_edge_s / 1e-8
    assert ticks == pytest.approx(np.rint(ticks), abs=1e-6)
    true_s = bench.edges(0, 9.0).time_s
    assert first.opening_edge_s == pytest.approx((true_s - true_s[0])[:4], abs=0.51e-8)


def test_a_board_without_edge_times_gives_none() -> None:
    bench = square_bench()
    counter = pmt(bench, edge_times=False)
    counter.arm(RUN)
    show(bench, [all_on()] * 10)
    block = counter.read(1.0)
    assert block.opening_edge_s is None
    assert block.closing_edge_s is None


def test_edges_before_arming_are_never_seen() -> None:
    bench = square_bench()
    counter = pmt(bench)
    show(bench, [all_on()] * 6 + [0 * all_on()] * 4)
    bench.clock.advance_to(3.5 * PICTURE_S)
    counter.arm(CounterRun(n_bins=6, period_s=PICTURE_S))
    (block,) = read_all(counter)
    assert block.counts.tolist() == [4.0, 4.0, 0.0, 0.0, 0.0, 0.0]


def test_a_run_after_a_run_starts_anew() -> None:
    bench = square_bench()
    counter = pmt(bench)
    for _ in range(2):
        counter.arm(RUN)
        show(bench, [all_on()] * 10, start_s=bench.clock.now_s())
        assert [block.first_bin for block in read_all(counter)] == [0, 4, 8]
        assert counter.disarm().edges_seen == 11
        bench.clock.sleep_s(1.0)


def test_a_missed_edge_leaves_the_run_one_bin_short() -> None:
    bench = square_bench(faults=[{"kind": "drop-edge", "picture": 3}])
    counter = pmt(bench)
    counter.arm(RUN)
    show(bench, [all_on()] * 10)
    counts = np.concatenate([block.counts for block in read_all(counter)])
    assert counts.tolist() == [4, 4, 8, 4, 4, 4, 4, 4, 4]
    assert counter.disarm().edges_seen == 10


def test_a_stalled_modulator_leaves_reads_empty() -> None:
    bench = square_bench(faults=[{"kind": "stall", "picture": 4}])
    counter = pmt(bench)
    counter.arm(RUN)
    show(bench, [all_on()] * 10)
    assert sum(len(block) for block in read_all(counter)) == 4
    assert len(counter.read(1.0)) == 0


@pytest.mark.parametrize(
    ("fault", "error"), [("overrun_at_bin", CounterOverrun), ("unplugged_at_bin", DeviceDisconnected)]
)
def test_when_it_breaks_it_first_hands_over_all_that_is_good(fault: str, error: type[Exception]) -> None:
    bench = square_bench()
    counter = pmt(bench, **{fault: 6})
    counter.arm(RUN)
    show(bench, [all_on()] * 10)
    assert [len(counter.read(1.0)), len(counter.read(1.0))] == [4, 2]
    with pytest.raises(error, match="bin 6"):
        counter.read(1.0)
    assert counter.disarm().bins_closed == 6


@pytest.mark.parametrize(
    ("settings", "run", "words"),
    [
        ({"max_sync_rate_hz": 1e4}, RUN, "20000 sync edges a second; expected at most 10000"),
        ({"max_bins": 9}, RUN, "a run of 10 patterns; expected at most 9 patterns a run"),
    ],
)
def test_a_run_beyond_its_limits_is_refused(settings: dict[str, object], run: CounterRun, words: str) -> None:
    with pytest.raises(PlanError, match=words):
        pmt(bench_with(), **settings).arm(run)


def test_its_life_is_arm_read_disarm() -> None:
    counter = pmt(bench_with())
    with pytest.raises(WrongState, match="while not armed"):
        counter.read(1.0)
    assert counter.disarm().bins_closed == 0
    with counter:
        counter.arm(RUN)
        with pytest.raises(WrongState, match="while armed"):
            counter.arm(RUN)
    with pytest.raises(WrongState, match="after the device was closed"):
        counter.arm(RUN)
    assert counter.disarm().edges_seen is None
