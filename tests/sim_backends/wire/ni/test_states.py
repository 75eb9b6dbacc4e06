"""The task's life, the counters that only one task can hold, and what is refused (4.2, 4.5, 4.7)."""

import sys

import pytest

from protocols import BenchContext, DriverUnavailable, InputError
from sim_backends.wire.ni import NiEmulatorSettings, open_emulator, plugin
from tests.sim_backends.projector import bench_with
from tests.sim_backends.wire.ni.rig import (
    CONTINUOUS,
    PHOTONS,
    code_of,
    constants,
    cumulated,
    ni_rig,
    nidaqmx,
    read,
)


def test_a_counter_belongs_to_one_task_from_reserving_to_unreserving() -> None:
    modes = constants.TaskMode
    with ni_rig() as rig:
        first, second = rig.task(start=False), rig.task(start=False)
        first.control(modes.TASK_VERIFY)
        second.control(modes.TASK_RESERVE)
        assert code_of(first.control, modes.TASK_RESERVE) == -50103
        assert code_of(first.start) == -50103
        second.control(modes.TASK_UNRESERVE)
        first.start()
        assert code_of(second.start) == -50103
        first.stop()
        second.start()


def test_a_committed_task_keeps_its_counter_when_it_stops() -> None:
    with ni_rig() as rig:
        first, second = rig.task(start=False), rig.task(start=False)
        first.control(constants.TaskMode.TASK_COMMIT)
        first.start()
        first.stop()
        assert code_of(second.start) == -50103
        first.control(constants.TaskMode.TASK_ABORT)
        second.start()


def test_closing_a_task_frees_its_counter() -> None:
    with ni_rig() as rig:
        with nidaqmx.Task(grpc_options=rig.options) as task:
            task.ci_channels.add_ci_count_edges_chan("Dev1/ctr0")
            task.start()
        rig.task()


def test_a_task_can_be_armed_again_and_counts_from_nothing() -> None:
    with ni_rig() as rig:
        task = rig.task()
        for _ in range(2):
            rig.show(5)
            assert read(task, 6).tolist() == cumulated(rig.bins(5))
            task.stop()
            rig.bench.clock.sleep_s(0.1)
            task.start()


def test_a_read_starts_a_task() -> None:
    with ni_rig() as rig:
        task = rig.task(start=False)
        rig.show(5)
        assert read(task, 6).tolist() == cumulated(rig.bins(5))


@pytest.mark.parametrize(("counter", "code"), [("Dev9/ctr0", -200220), ("Dev1/ctr7", -200170), ("Dev1/ai0", -200170)])
def test_a_counter_that_does_not_exist_is_refused(counter: str, code: int) -> None:
    with ni_rig() as rig:
        assert code_of(rig.raw_task().ci_channels.add_ci_count_edges_chan, counter) == code


def test_a_task_takes_one_counter_only() -> None:
    with ni_rig() as rig:
        assert code_of(rig.task(start=False).ci_channels.add_ci_count_edges_chan, "Dev1/ctr1") == -200147


def test_a_task_without_a_channel_cannot_start() -> None:
    with ni_rig() as rig:
        assert code_of(rig.raw_task().start) == -200478


def test_a_name_is_taken_once() -> None:
    with ni_rig() as rig:
        rig.raw_task("photons")
        assert code_of(nidaqmx.Task, "photons", grpc_options=rig.options) == -200089


@pytest.mark.parametrize("terminal", ["/Dev1/PFI99", "/Dev2/PFI8", "CLKI"])
def test_a_terminal_that_does_not_exist_is_found_at_the_start(terminal: str) -> None:
    with ni_rig() as rig:
        assert code_of(rig.task(term=terminal, start=False).start) == -89120
        assert code_of(rig.task(clock=terminal, start=False).control, constants.TaskMode.TASK_VERIFY) == -89120


def test_a_terminal_that_cannot_be_routed_is_found_at_the_start() -> None:
    with ni_rig(unroutable=("PFI8",)) as rig:
        assert code_of(rig.task(start=False).start) == -89136


@pytest.mark.parametrize("source", ["", "OnboardClock"])
def test_buffered_edge_counting_needs_an_external_clock(source: str) -> None:
    with ni_rig() as rig:
        assert code_of(rig.task(clock=source, start=False).start) == -200303


def test_a_pause_trigger_and_a_sample_clock_exclude_each_other() -> None:
    with ni_rig() as rig:
        task = rig.task(start=False)
        task.triggers.pause_trigger.trig_type = constants.TriggerType.DIGITAL_LEVEL
        assert code_of(task.start) == -200145


def test_a_board_without_sample_clock_or_arm_start_refuses_them() -> None:
    with ni_rig(ci_samp_clk_supported=False, arm_start_supported=False) as rig:
        task = rig.raw_task()
        task.ci_channels.add_ci_count_edges_chan("Dev1/ctr0")
        assert code_of(task.timing.cfg_samp_clk_timing, 1000, source="PFI9", sample_mode=CONTINUOUS) == -200077
        task.triggers.arm_start_trigger.trig_type = constants.TriggerType.DIGITAL_EDGE
        assert code_of(task.start) == -200077


def test_a_running_task_cannot_be_configured() -> None:
    with ni_rig() as rig:
        task = rig.task()
        assert code_of(setattr, task.in_stream, "input_buf_size", 5) == -200479
        assert code_of(task.timing.cfg_samp_clk_timing, 1000, source="PFI9") == -200479


def test_an_attribute_that_counters_do_not_have_is_refused() -> None:
    with ni_rig() as rig:
        assert code_of(getattr, rig.task(start=False).timing, "ref_clk_rate") == -200452


def test_what_is_set_is_told_and_reset() -> None:
    with ni_rig() as rig:
        timing = rig.task(start=False).timing
        assert (timing.samp_clk_rate, timing.samp_clk_src) == (20_000.0, "/Dev1/PFI9")
        timing.samp_clk_dig_fltr_enable = True
        assert timing.samp_clk_dig_fltr_enable
        del timing.samp_clk_dig_fltr_enable
        assert not timing.samp_clk_dig_fltr_enable


def test_a_scene_that_counts_no_photons_is_refused_with_what_to_write() -> None:
    bench = bench_with(noise={"kind": "none"})
    with pytest.raises(InputError, match=r'choose noise = \{ kind = "poisson" \}'):
        plugin.open(NiEmulatorSettings(), BenchContext(scene=bench))


def test_without_nidaqmx_the_plugin_says_what_to_install(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "sim_backends.wire.ni.emulator", None)
    with pytest.raises(DriverUnavailable, match=r"install kinopix\[ni\]"):
        open_emulator(NiEmulatorSettings(), BenchContext(scene=bench_with(noise=PHOTONS)))


def test_closing_twice_is_allowed() -> None:
    with ni_rig() as rig:
        rig.options.close()
        rig.options.close()


def test_a_task_is_started_and_stopped_by_control_too_and_tells_its_channels() -> None:
    with ni_rig() as rig:
        task = rig.task(start=False)
        task.control(constants.TaskMode.TASK_START)
        task.start()
        assert not task.is_task_done()
        assert (task.channel_names, task.number_of_channels, task.number_of_devices) == (["Dev1/ctr0"], 1, 1)
        task.control(constants.TaskMode.TASK_STOP)
        assert task.is_task_done()
        task.wait_until_done(1.0)
        assert rig.bench.clock.now_s() == 0.0


def test_counting_down_is_a_direction_and_other_directions_are_refused() -> None:
    with ni_rig() as rig:
        chans = rig.raw_task().ci_channels
        down = constants.CountDirection.COUNT_DOWN
        external = constants.CountDirection.EXTERNAL_SOURCE
        assert code_of(chans.add_ci_count_edges_chan, "Dev1/ctr0", count_direction=external) == -200077
        chans.add_ci_count_edges_chan("Dev1/ctr0", count_direction=down, initial_count=1000)
        task = chans[0]
        assert task.ci_count == 1000
