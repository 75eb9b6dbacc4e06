"""The observed trace of the sheet (4.1 and 4.7), played again by the real client against the emulated board."""

import threading

import numpy as np

from tests.sim_backends.wire.ni.rig import CONTINUOUS, constants, cumulated, ni_rig, nidaqmx, readers, system


def test_the_whole_life_of_a_task_call_by_call() -> None:
    versions = ["GetSystemInfoAttributeUInt32"] * 3
    with ni_rig() as rig:
        task = nidaqmx.Task(grpc_options=rig.options)
        assert rig.calls() == [*versions, "CreateTask", "GetTaskAttributeString"]
        channel = task.ci_channels.add_ci_count_edges_chan("Dev1/ctr0")
        assert "CreateCICountEdgesChan" in rig.calls()
        channel.ci_count_edges_term = "/Dev1/PFI8"
        channel.ci_dup_count_prevention = True
        assert rig.calls() == ["SetChanAttributeString", "SetChanAttributeBool"]
        task.timing.cfg_samp_clk_timing(20_000, source="/Dev1/PFI9", sample_mode=CONTINUOUS, samps_per_chan=9997)
        assert rig.calls() == ["CfgSampClkTiming"]
        arm = task.triggers.arm_start_trigger
        arm.trig_type = constants.TriggerType.DIGITAL_EDGE
        arm.dig_edge_src = "/Dev1/PFI9"
        arm.dig_edge_edge = constants.Edge.RISING
        arm.trig_type = constants.TriggerType.NONE
        assert rig.calls() == ["SetTrigAttributeInt32", "SetTrigAttributeString", *["SetTrigAttributeInt32"] * 2]
        task.in_stream.input_buf_size = 20_000
        task.in_stream.overwrite = constants.OverwriteMode.DO_NOT_OVERWRITE_UNREAD_SAMPLES
        task.in_stream.read_all_avail_samp = True
        assert rig.calls() == ["SetBufferAttributeUInt32", "SetReadAttributeInt32", "SetReadAttributeBool"]
        told, enough = list[int](), threading.Event()

        def arrived(_task: object, _kind: object, n: int, _data: object) -> int:
            told.append(n)
            if len(told) == 3:
                enough.set()
            return 0

        task.register_every_n_samples_acquired_into_buffer_event(100, arrived)
        assert rig.calls() == ["RegisterEveryNSamplesEvent"]
        task.start()
        assert rig.calls() == ["StartTask"]

        rig.show(300)
        data = np.zeros(301, np.uint32)
        assert readers.CounterReader(task.in_stream).read_many_sample_uint32(data, 301, timeout=1.0) == 301
        assert rig.calls() == ["GetReadAttributeUInt32", "ReadCounterU32Ex"]
        assert data.tolist() == cumulated(rig.bins(300))
        assert enough.wait(10)
        assert told == [100, 100, 100]

        assert (task.in_stream.avail_samp_per_chan, task.in_stream.total_samp_per_chan_acquired) == (0, 301)
        assert task.in_stream.curr_read_pos == 301
        assert rig.calls() == ["GetReadAttributeUInt32", "GetReadAttributeUInt64", "GetReadAttributeUInt64"]
        assert not task.is_task_done()
        task.control(constants.TaskMode.TASK_COMMIT)
        task.stop()
        assert rig.calls() == ["IsTaskDone", "TaskControl", "StopTask"]
        task.close()
        assert rig.calls() == ["ClearTask"]


def test_the_client_asks_in_two_ways_what_read_all_means() -> None:
    """From driver 24.5 on by attribute 0x31E8, before by the sample quantity: a finite task waits for all."""
    for version, asked in (((24, 8, 0), "GetReadAttributeUInt32"), ((23, 0, 0), "GetTimingAttributeInt32")):
        with ni_rig(driver_version=version) as rig:
            task = rig.task(mode=constants.AcquisitionType.FINITE, samples=6)
            rig.show(5)
            rig.calls()
            data = np.zeros(6, np.uint32)
            assert readers.CounterReader(task.in_stream).read_many_sample_uint32(data) == 6
            assert rig.calls()[0] == asked
            assert data.tolist() == cumulated(rig.bins(5))


def test_task_read_gives_floats_for_counters() -> None:
    with ni_rig() as rig:
        task = rig.task()
        rig.show(2)
        rig.calls()
        values = task.read(3)
        assert values == cumulated(rig.bins(2))
        assert {type(value) for value in values} == {float}
        assert rig.calls()[-1] == "ReadCounterF64Ex"


def test_the_device_tells_what_the_sheet_lists() -> None:
    with ni_rig(devices=("Dev1", "Dev2")) as rig:
        devices = system.System.remote(rig.options).devices
        assert devices.device_names == ["Dev1", "Dev2"]
        device = devices["Dev1"]
        assert (device.product_type, device.is_simulated, device.ci_samp_clk_supported) == ("PCIe-6321", False, True)
        assert (device.ci_max_size, device.ci_max_timebase) == (32, 100e6)
        assert constants.TriggerUsage.ARM_START in device.ci_trig_usage
        assert device.ci_meas_types == [constants.UsageTypeCI.COUNT_EDGES]
        assert {"/Dev1/PFI9", "/Dev1/100MHzTimebase", "/Dev1/Ctr0InternalOutput"} <= set(device.terminals)
        assert device.ci_physical_chans.channel_names[:2] == ["Dev1/ctr0", "Dev1/ctr1"]


def test_a_board_without_arm_start_says_so() -> None:
    """As a USB-6421's manual has it."""
    with ni_rig(arm_start_supported=False) as rig:
        usage = system.System.remote(rig.options).devices["Dev1"].ci_trig_usage
        assert usage == [constants.TriggerUsage.PAUSE]
