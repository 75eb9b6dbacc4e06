"""Each fault of the list, as the client sees it (4.5, 12)."""

import numpy as np
import pytest

from tests.sim_backends.wire.ni.rig import (
    code_of,
    constants,
    cumulated,
    errors,
    ni_rig,
    nidaqmx,
    read,
    read_failing,
    system,
)

READ_ERRORS = (
    -200279, -200222, -200361, -200010, -209829, -200141, -201314, -201313, -200140, -200313, -200314, -200278,
    -201003, -200324, -200220, -50103, -200022, -89137, -88709, -88710, -200474, -999999,
)  # fmt: skip


@pytest.mark.parametrize("code", READ_ERRORS)
def test_a_read_error_leaves_the_samples_before_it(code: int) -> None:
    with ni_rig(faults=[{"kind": "read-error", "code": code, "at": 7}]) as rig:
        task = rig.task()
        rig.show(20)
        assert read(task, 7).tolist() == cumulated(rig.bins(6))
        assert read_failing(task, 1) == (code, [])
        assert read_failing(task, 1) == (code, [])
        assert task.in_stream.total_samp_per_chan_acquired == 7


def test_a_read_error_in_the_status_brings_the_good_samples_along() -> None:
    with ni_rig(faults=[{"kind": "read-error", "code": -200361, "at": 7, "give": "status"}]) as rig:
        task = rig.task()
        rig.show(20)
        assert read_failing(task, 21) == (-200361, cumulated(rig.bins(6)))


def test_a_bare_error_is_no_read_error() -> None:
    with ni_rig(faults=[{"kind": "read-error", "code": -201314, "at": 2, "give": "bare"}]) as rig:
        task = rig.task()
        rig.show(20)
        with pytest.raises(errors.DaqError) as raised:
            read(task, 3)
        assert type(raised.value) is errors.DaqError
        assert raised.value.error_code == -201314


def test_an_error_may_concern_one_counter_only() -> None:
    with ni_rig(faults=[{"kind": "read-error", "code": -200361, "at": 3, "counter": "ctr1"}]) as rig:
        photons, clock = rig.task(), rig.task(counter="Dev1/ctr1", term="100MHzTimebase")
        rig.show(10)
        assert len(read(photons, 11)) == 11
        assert read_failing(clock, 11) == (-200361, [])


def test_the_error_comes_when_its_sample_would_have_come() -> None:
    with ni_rig(faults=[{"kind": "read-error", "code": -200361, "at": 7}]) as rig:
        task = rig.task()
        rig.show(20)
        assert read_failing(task, 21, timeout_s=10.0) == (-200361, [])
        assert rig.bench.clock.now_s() == pytest.approx(0.001 + 7 * 50e-6)


def test_a_short_read_gives_part_and_the_next_one_the_rest() -> None:
    with ni_rig(faults=[{"kind": "short-read", "at": 5}]) as rig:
        task = rig.task()
        rig.show(9)
        code, first = read_failing(task, 10)
        assert (code, len(first)) == (-200284, 5)
        assert first + read(task, 5).tolist() == cumulated(rig.bins(9))


def test_a_latch_race_moves_a_count_to_the_next_bin() -> None:
    with ni_rig(faults=[{"kind": "latch-race", "at": 4}, {"kind": "latch-race", "at": 7, "counts": -2}]) as rig:
        task = rig.task()
        rig.show(9)
        off = np.diff(read(task, 10).astype(np.int64)) - np.array(rig.bins(9))
        assert off.tolist() == [0, 0, 0, -1, 1, 0, 2, -2, 0]


def test_an_unplugged_board_fails_every_call_but_closing() -> None:
    with ni_rig(faults=[{"kind": "unplug", "at": 4}]) as rig:
        task = rig.task()
        rig.show(9)
        assert read(task, 4).tolist() == cumulated(rig.bins(3))
        assert read_failing(task, 1) == (-201003, [])
        assert code_of(task.stop) == -201003
        assert code_of(getattr, system.System.remote(rig.options).devices["Dev1"], "product_type") == -201003


def test_a_server_that_vanishes_is_unavailable_from_then_on() -> None:
    with ni_rig(faults=[{"kind": "server-vanishes", "at": 4}]) as rig:
        task = nidaqmx.Task(grpc_options=rig.options)
        task.ci_channels.add_ci_count_edges_chan("Dev1/ctr0")
        task.timing.cfg_samp_clk_timing(20_000, source="PFI9", sample_mode=constants.AcquisitionType.CONTINUOUS)
        task.start()
        rig.show(9)
        assert read(task, 4).tolist() == cumulated(rig.bins(3))
        for attempt in (lambda: read(task, 1), task.stop, task.close):
            with pytest.raises(errors.RpcError, match="Failed to connect to server"):
                attempt()


def test_a_task_that_the_board_has_forgotten_is_invalid() -> None:
    with ni_rig() as rig:
        task = nidaqmx.Task(grpc_options=rig.options)
        rig.options.service.board.close()
        assert code_of(task.start) == -200088
        task.close()


@pytest.mark.parametrize("code", [-50103, -200022])
def test_a_counter_held_by_another_program(code: int) -> None:
    with ni_rig(faults=[{"kind": "held", "counter": "ctr1", "code": code}]) as rig:
        rig.task()
        assert code_of(rig.task(counter="Dev1/ctr1", start=False).start) == code


def test_any_call_can_fail_once() -> None:
    with ni_rig(faults=[{"kind": "call", "rpc": "StartTask", "nth": 2, "code": -89137}]) as rig:
        rig.task()
        second = rig.task(counter="Dev1/ctr1", start=False)
        assert code_of(second.start) == -89137
        second.start()


def test_a_call_can_be_late() -> None:
    with ni_rig(faults=[{"kind": "call", "rpc": "IsTaskDone", "delay_s": 0.5}]) as rig:
        assert not rig.task().is_task_done()
        assert rig.bench.clock.now_s() == 0.5


def test_unregistering_an_event_ends_its_stream() -> None:
    """A stream that is left open would hang the process at exit."""
    with ni_rig() as rig:
        task = rig.task(start=False)
        told: list[int] = []

        def arrived(_task: object, _kind: object, n: int, _data: object) -> int:
            told.append(n)
            return 0

        task.register_every_n_samples_acquired_into_buffer_event(5, arrived)
        task.register_every_n_samples_acquired_into_buffer_event(5, None)
        task.start()
        rig.show(20)
        read(task, 21)
        assert told == []
