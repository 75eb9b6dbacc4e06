"""Which samples a counter gives: cumulative counts at each edge, to the bit those of the bench."""

from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from protocols import BenchContext, CounterRun
from sim_backends.devices.counter import CounterSettings, open_counter
from tests.sim_backends.projector import PICTURE_S
from tests.sim_backends.wire.ni.rig import (
    FINITE,
    Rig,
    code_of,
    constants,
    cumulated,
    errors,
    ni_rig,
    read,
    read_failing,
    readers,
)


def test_samples_are_the_counts_since_arming_and_their_differences_the_bins() -> None:
    with ni_rig() as rig:
        task = rig.task()
        rig.show(600)
        samples = read(task, 601)
        assert samples[0] == 3
        assert np.diff(samples).tolist() == rig.bins(600)


def test_the_register_wraps_at_32_bits_and_unsigned_differences_do_not_notice() -> None:
    with ni_rig() as rig:
        task = rig.task(initial=2**32 - 100)
        rig.show(40)
        samples = read(task, 41)
        assert samples[-1] < samples[0]
        assert np.diff(samples).tolist() == rig.bins(40)
        channel = task.ci_channels[0]
        assert (channel.ci_tc_reached, channel.ci_tc_reached) == (True, False)
        assert channel.ci_count == samples[-1]


def test_a_second_counter_on_the_same_clock_gives_the_time_of_each_edge_in_ticks() -> None:
    """Armed at 0, first edge at 1 ms, 50 us pictures: 100,000 ticks of 10 ns, then 5,000 each; 50 ns: a fifth."""
    with ni_rig() as rig:
        photons = rig.task()
        fine = rig.task(counter="Dev1/ctr1", term="/Dev1/100MHzTimebase")
        coarse = rig.task(counter="Dev1/ctr2", term="20MHzTimebase")
        rig.show(100)
        assert np.diff(read(photons, 101)).tolist() == rig.bins(100)
        assert read(fine, 101).tolist() == [100_000 + 5_000 * k for k in range(101)]
        assert read(coarse, 101).tolist() == [20_000 + 1_000 * k for k in range(101)]


def test_a_crystal_that_is_fast_counts_more_ticks() -> None:
    with ni_rig(timebase_ppm=100.0) as rig:
        task = rig.task(term="/Dev1/100MHzTimebase")
        rig.show(100)
        assert read(task, 101)[[0, -1]].tolist() == [100_010, 600_060]


@settings(max_examples=8, deadline=None, suppress_health_check=[HealthCheck.too_slow])
@given(blocks=st.lists(st.tuples(st.integers(0, 1), st.integers(1, 40)), min_size=1, max_size=10))
def test_whoever_reads_first_no_sample_is_lost(blocks: list[tuple[int, int]]) -> None:
    """Reading one task lets time pass for the other as well."""
    with ni_rig() as rig:
        tasks = [rig.task(counter=f"Dev1/ctr{k}") for k in (0, 1)]
        rig.show(400)
        got: list[list[int]] = [[], []]
        for which, n in blocks:
            got[which] += read(tasks[which], n).tolist()
        for which in (0, 1):
            got[which] += read(tasks[which], 401 - len(got[which])).tolist()
            assert got[which] == cumulated(rig.bins(400))


def test_without_duplicate_count_prevention_dark_bins_give_no_sample() -> None:
    """The trap: bins shift silently."""
    scene: dict[str, object] = {"noise": {"kind": "poisson", "peak_counts": 1.5, "seed": 2}}
    with ni_rig(scene=scene) as rig:
        task = rig.task(start=False)
        task.ci_channels[0].ci_dup_count_prevention = False
        task.start()
        rig.show(200)
        bins = rig.bins(200)
        lit = [count for count in bins if count]
        assert 0 < len(lit) < 200
        rig.bench.clock.sleep_s(1.0)
        assert task.in_stream.avail_samp_per_chan == 1 + len(lit)
        assert read(task, 1 + len(lit)).tolist() == cumulated(lit)


def test_a_prescaler_turns_duplicate_count_prevention_off() -> None:
    with ni_rig() as rig:
        channel = rig.task(start=False).ci_channels[0]
        assert channel.ci_dup_count_prevention
        channel.ci_prescaler = 2
        assert not channel.ci_dup_count_prevention


def test_the_first_edge_may_give_no_sample() -> None:
    with ni_rig(first_edge_sampled=False) as rig:
        task = rig.task()
        rig.show(5)
        assert read(task, 5).tolist() == cumulated(rig.bins(5))[1:]


@pytest.mark.parametrize(("sampled", "samples"), [(False, 5), (True, 6)])
def test_arming_on_the_sync_line_leaves_open_whether_the_first_edge_is_a_sample(sampled: object, samples: int) -> None:
    with ni_rig(arm_edge_sampled=sampled) as rig:
        task = armed_by(rig, "/Dev1/PFI9")
        rig.show(5)
        assert read(task, samples).tolist() == cumulated(rig.bins(5), before=0)[-samples:]
        assert read_failing(task, 1) == (-200284, [])


def test_arming_on_a_line_without_a_signal_never_counts() -> None:
    with ni_rig() as rig:
        task = armed_by(rig, "/Dev1/PFI2")
        rig.show(5)
        assert read_failing(task, 1) == (-200284, [])
        assert task.ci_channels[0].ci_count == 0


def test_a_sequence_start_line_arms_before_the_first_edge() -> None:
    with ni_rig(start_line="PFI2") as rig:
        task = armed_by(rig, "/Dev1/PFI2")
        rig.show(5)
        assert read(task, 6).tolist() == cumulated(rig.bins(5), before=0)


def armed_by(rig: Rig, line: str) -> Any:
    task = rig.task(start=False)
    arm = task.triggers.arm_start_trigger
    arm.trig_type, arm.dig_edge_src = constants.TriggerType.DIGITAL_EDGE, line
    task.start()
    return task


def test_a_cable_on_another_terminal_gives_no_counts_or_no_samples() -> None:
    with ni_rig() as rig:
        dark, unclocked = rig.task(term="/Dev1/PFI3"), rig.task(counter="Dev1/ctr1", clock="/Dev1/PFI1")
        rig.show(5)
        assert read(dark, 6).tolist() == [0] * 6
        assert read_failing(unclocked, 1) == (-200284, [])


def test_a_filter_on_the_photon_line_takes_every_pulse_and_one_on_the_clock_only_narrow_syncs() -> None:
    """125 ns are the fastest filter: more than the head's 10 ns, less than the sync's 10 us."""
    with ni_rig() as rig:
        task = rig.task(start=False)
        task.timing.samp_clk_dig_fltr_enable = True
        task.timing.samp_clk_dig_fltr_min_pulse_width = 125e-9
        task.ci_channels[0].ci_count_edges_dig_fltr_enable = True
        task.ci_channels[0].ci_count_edges_dig_fltr_min_pulse_width = 125e-9
        task.start()
        rig.show(5)
        assert read(task, 6).tolist() == [0] * 6
    with ni_rig(sync_pulse_s=100e-9) as rig:
        task = rig.task(start=False)
        task.timing.samp_clk_dig_fltr_enable = True
        task.timing.samp_clk_dig_fltr_min_pulse_width = 125e-9
        rig.show(5)
        assert read_failing(task, 1) == (-200284, [])


def test_a_board_that_needs_wider_pulses_misses_all_of_them() -> None:
    """cDAQ-9172, external source mode: 16 ns."""
    with ni_rig(min_source_pulse_s=16e-9) as rig:
        task = rig.task()
        rig.show(5)
        assert read(task, 6).tolist() == [0] * 6


def test_a_finite_task_does_not_see_surplus_edges_and_ends() -> None:
    scene: dict[str, object] = {"faults": [{"kind": "surplus-edges", "edges": 3}]}
    with ni_rig(scene=scene) as rig:
        task = rig.task(mode=FINITE, samples=6)
        rig.show(5)
        task.wait_until_done(1.0)
        assert rig.bench.clock.now_s() == pytest.approx(0.001 + 5 * PICTURE_S)
        assert task.is_task_done()
        rig.bench.clock.sleep_s(1.0)
        assert task.in_stream.total_samp_per_chan_acquired == 6
        assert read(task, 6).tolist() == cumulated(rig.bins(5))
        assert read_failing(task, 1) == (-200278, [])


def test_a_continuous_task_sees_surplus_and_missing_edges() -> None:
    faults = [{"kind": "surplus-edges", "edges": 3}, {"kind": "drop-edge", "picture": 2}]
    with ni_rig(scene={"faults": faults}) as rig:
        task = rig.task()
        rig.show(5)
        rig.bench.clock.sleep_s(1.0)
        assert task.in_stream.avail_samp_per_chan == 6 + 3 - 1


def test_a_read_waits_until_its_samples_are_there_and_no_longer() -> None:
    with ni_rig() as rig:
        task = rig.task()
        rig.show(100)
        read(task, 11, timeout_s=10.0)
        assert rig.bench.clock.now_s() == pytest.approx(0.001 + 10 * PICTURE_S)


def test_a_read_whose_time_is_over_gives_what_there_is() -> None:
    with ni_rig() as rig:
        task = rig.task()
        rig.show(5)
        assert read_failing(task, 10, timeout_s=0.25) == (-200284, cumulated(rig.bins(5)))
        assert rig.bench.clock.now_s() == pytest.approx(0.25)
        assert task.in_stream.curr_read_pos == 6


def test_an_endless_read_of_a_stalled_modulator_ends_when_patience_is_over() -> None:
    with ni_rig(scene={"faults": [{"kind": "stall", "picture": 2}]}, patience_s=60.0) as rig:
        task = rig.task()
        rig.show(5)
        assert read_failing(task, 6, timeout_s=-1.0) == (-200284, cumulated(rig.bins(2)))
        assert rig.bench.clock.now_s() == 60.0


@pytest.mark.parametrize("readable", [False, True])
def test_a_full_buffer_stops_a_continuous_task(readable: object) -> None:
    with ni_rig(readable_after_overrun=readable) as rig:
        task = rig.task(start=False)
        task.in_stream.input_buf_size = 50
        task.start()
        rig.show(100)
        first = read(task, 10).tolist()
        rig.bench.clock.sleep_s(1.0)
        if readable:
            assert first + read(task, 50).tolist() == cumulated(rig.bins(59))
        assert read_failing(task, 1) == (-200222, [])
        assert task.in_stream.total_samp_per_chan_acquired == 60


def test_an_overwritten_ring_says_that_the_samples_are_gone() -> None:
    with ni_rig() as rig:
        task = rig.task(start=False)
        task.in_stream.input_buf_size = 50
        task.in_stream.overwrite = constants.OverwriteMode.OVERWRITE_UNREAD_SAMPLES
        task.start()
        rig.show(100)
        rig.bench.clock.sleep_s(1.0)
        assert read_failing(task, 1) == (-200279, [])


@pytest.mark.parametrize(("rate_hz", "size"), [(100, 1000), (10_000, 10_000), (20_000, 100_000), (2e6, 1_000_000)])
def test_a_continuous_task_gets_a_buffer_by_its_rate(rate_hz: float, size: int) -> None:
    with ni_rig() as rig:
        task = rig.task(start=False)
        task.timing.cfg_samp_clk_timing(rate_hz, source="PFI9", sample_mode=constants.AcquisitionType.CONTINUOUS)
        assert task.in_stream.input_buf_size == size


def test_a_task_without_a_clock_reads_the_live_register() -> None:
    with ni_rig() as rig:
        task = rig.raw_task()
        task.ci_channels.add_ci_count_edges_chan("Dev1/ctr0")
        task.start()
        rig.show(3)
        rig.bench.clock.sleep_s(1.0)
        assert task.read() == sum(rig.bins(3)) + 3


def test_a_wait_for_a_continuous_task_is_never_done() -> None:
    with ni_rig() as rig:
        task = rig.task()
        assert code_of(task.wait_until_done, 0.5) == -200560
        assert rig.bench.clock.now_s() == 0.5


def test_two_edges_too_close_together_are_an_overrun() -> None:
    """-201314 alone, without a count of samples, is no read error for the client."""
    faults = [{"kind": "double-edge", "picture": 3, "after_s": 50e-9}]
    with ni_rig(scene={"faults": faults}, min_sample_gap_s=100e-9) as rig:
        task = rig.task()
        rig.show(10)
        assert read(task, 4).tolist() == cumulated(rig.bins(3))
        with pytest.raises(errors.DaqError) as raised:
            read(task, 1)
        assert raised.value.error_code == -201314
        assert not isinstance(raised.value, errors.DaqReadError)


def test_two_threads_that_read_in_turn_lose_nothing() -> None:
    with ni_rig() as rig:
        tasks = [rig.task(), rig.task(counter="Dev1/ctr1", term="/Dev1/100MHzTimebase")]
        rig.show(600)

        def in_blocks(task: Any) -> list[int]:
            return [int(sample) for _ in range(40) for sample in read(task, 15)]

        with ThreadPoolExecutor(2) as pool:
            photons, ticks = pool.map(in_blocks, tasks)
        assert photons == cumulated(rig.bins(599))
        assert ticks == [100_000 + 5_000 * k for k in range(600)]


def test_counts_and_edge_times_are_those_of_the_simulated_counter() -> None:
    """Same seed, another bench: one board deep, one not."""
    with ni_rig(scene={"sync_jitter_s": 1e-6}) as rig:
        photons, clock = rig.task(), rig.task(counter="Dev1/ctr1", term="/Dev1/100MHzTimebase")
        rig.show(600)
        bins, ticks = np.diff(read(photons, 601)), read(clock, 601).astype(np.int64)
    with ni_rig(scene={"sync_jitter_s": 1e-6}) as rig:
        counter = open_counter(CounterSettings(), BenchContext(scene=rig.bench))
        counter.arm(CounterRun(n_bins=600, period_s=PICTURE_S, latency_s=1.0))
        rig.show(600)
        block = counter.read(1.0)
    assert bins.tolist() == block.counts.tolist()
    assert block.opening_edge_s is not None
    assert (ticks[:-1] - ticks[0]) * 1e-8 == pytest.approx(block.opening_edge_s, abs=1.01e-8)


def test_one_sample_can_be_read_alone() -> None:
    with ni_rig() as rig:
        task = rig.task()
        rig.show(2)
        reader = readers.CounterReader(task.in_stream)
        assert reader.read_one_sample_uint32(timeout=1.0) == 3
        assert reader.read_one_sample_double(timeout=1.0) == 3.0 + rig.bins(1)[0]
        reader.read_one_sample_uint32(timeout=1.0)
        assert code_of(reader.read_one_sample_uint32, timeout=1.0) == -200284


@pytest.mark.parametrize(("within_ns", "share"), [(0.0, 0.0), (40.0, 0.181), (80.0, 0.330)])
def test_photons_too_close_to_each_other_are_one_edge(within_ns: float, share: float) -> None:
    """250 photons in 50 us are 5 a microsecond: a neighbour within 40 ns with 1 - exp(-0.2) = 0.181, within 80 ns 0.330."""
    with ni_rig(merge_within_s=within_ns * 1e-9) as rig:
        task = rig.task()
        rig.show(200)
        counted = np.diff(read(task, 201))
        came = np.array(rig.bins(200))
    lit = came > 100
    rate = came[lit].mean() / 50e3
    expected = 1 - np.exp(-rate * within_ns)
    assert abs(1 - counted[lit].sum() / came[lit].sum() - expected) < 0.02
    assert expected == pytest.approx(share, abs=0.01)
    assert (counted <= came).all()
