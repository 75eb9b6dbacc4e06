"""Call sequences of NI's own examples (ni/nidaqmx-python, examples/counter_in and examples/system), over the gRPC server."""

import numpy as np
import pytest

from tests.sim_backends.wire.ni.rig import CONTINUOUS, constants, ni_rig, system


def test_the_system_s_properties_are_told() -> None:
    """system_properties: version, then name, category and type of each device."""
    with ni_rig() as rig:
        remote = system.System.remote(rig.options)
        version = remote.driver_version
        assert (version.major_version, version.minor_version, version.update_version) == (24, 8, 0)
        (device,) = remote.devices
        assert (device.name, device.product_category, device.product_type) == (
            "Dev1", constants.ProductCategory.X_SERIES_DAQ, "PCIe-6321",
        )  # fmt: skip
        assert device.bus_type == constants.BusType.PCIE
        assert [channel.name for channel in device.ci_physical_chans] == [f"Dev1/ctr{n}" for n in range(4)]
        assert {"/Dev1/PFI8", "/Dev1/PFI9", "/Dev1/100MHzTimebase"} <= set(device.terminals)


@pytest.mark.parametrize(("bus", "mechanism"), [("PCIe", "DMA"), ("USB", "USB_BULK")])
def test_counter_data_travel_as_the_bus_has_it(bus: str, mechanism: str) -> None:
    with ni_rig(bus=bus) as rig:
        channel = rig.task(start=False).ci_channels[0]
        assert channel.ci_data_xfer_mech == constants.DataTransferActiveTransferMode[mechanism]


def test_edges_are_counted_on_demand() -> None:
    """cnt_digital_events: PFI8, rising, up from 0; started, then read one value at a time."""
    with ni_rig() as rig:
        task = rig.raw_task()
        channel = task.ci_channels.add_ci_count_edges_chan(
            "Dev1/ctr0", edge=constants.Edge.RISING, initial_count=0, count_direction=constants.CountDirection.COUNT_UP
        )
        channel.ci_count_edges_term = "/Dev1/PFI8"
        task.start()
        before = task.read()
        rig.show(5)
        rig.bench.clock.sleep_s(0.01)
        assert (before, task.read()) == (3.0, 3.0 + sum(rig.bins(5)))


def test_counts_are_buffered_on_an_external_clock() -> None:
    """cont_cnt_buff_event_ext_clk: 1 kHz stated, PFI9, continuous; every value is the count since the start."""
    with ni_rig() as rig:
        task = rig.raw_task()
        channel = task.ci_channels.add_ci_count_edges_chan("Dev1/ctr0", edge=constants.Edge.RISING)
        task.timing.cfg_samp_clk_timing(1000, source="/Dev1/PFI9", sample_mode=CONTINUOUS)
        channel.ci_count_edges_term = "/Dev1/PFI8"
        task.start()
        rig.show(9)
        counts = task.read(number_of_samples_per_channel=10)
        assert counts[0] == 3.0
        assert np.diff(counts).tolist() == rig.bins(9)
