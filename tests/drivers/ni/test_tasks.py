"""The thin layer over ``nidaqmx``: the real client package against a server that answers a few calls from a list."""

from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from importlib import import_module
from types import SimpleNamespace
from typing import Any

import pytest

from drivers.ni.errors import NiFault
from drivers.ni.plugin import availability, open_counter, probe
from drivers.ni.settings import NiSettings
from drivers.ni.tasks import EdgeCount, NiBoardFacts, NiSystem, open_system
from protocols import BenchContext, CounterOverrun, CounterRun, DeviceDisconnected, DriverUnavailable, InputError
from tests.drivers.h10682.clock import ScriptClock

nidaqmx: Any = pytest.importorskip("nidaqmx")
grpc: Any = pytest.importorskip("grpc")
messages: Any = import_module("nidaqmx._stubs.nidaqmx_pb2")
stubs: Any = import_module("nidaqmx._stubs.nidaqmx_pb2_grpc")

COUNT = EdgeCount(
    counter="Dev1/ctr0",
    source="/Dev1/PFI8",
    clock="/Dev1/PFI9",
    clock_edge="falling",
    max_rate_hz=25_000,
    buffer_samples=200_000,
    prevent_duplicates=True,
    clock_filter_s=125e-9,
    arm="/Dev1/PFI1",
)


ANSWERS: dict[str, dict[str, Any]] = {
    "CreateTask": {"new_session_initialized": True},
    "GetReadAttributeUInt32 0x1223": {"value": 3},
    "GetReadAttributeUInt64 0x192a": {"value": 4},
    "GetDeviceAttributeString 0x631": {"value": "PCIe-6323"},
    "GetDeviceAttributeUInt32 0x632": {"value": 0x1A2B},
    "GetDeviceAttributeBool 0x299e": {"value": True},
    "GetDeviceAttributeUInt32 0x299f": {"value": 32},
    "GetDeviceAttributeDouble 0x29a0": {"value": 100e6},
    "GetDeviceAttributeString 0x2324": {"value": "Dev1/ctr0, Dev1/ctr1"},
    "GetSystemInfoAttributeString 0x193b": {"value": "Dev1, Dev2"},
    "GetSystemInfoAttributeUInt32 0x1272": {"value": 24},
}


class Server:
    """Answers reads from ``reads``: (status, samples), or an int for a call that is aborted with that code."""

    def __init__(self) -> None:
        self.calls: list[str] = []
        self.reads: list[tuple[int, list[int]] | int] = []
        self.refuses: dict[str, int] = {}

    def __getattr__(self, rpc: str) -> Any:
        if not rpc[0].isupper():
            raise AttributeError(rpc)

        def answer(request: Any, context: Any) -> Any:
            return self._answer(rpc, request, context)

        return answer

    def _answer(self, rpc: str, request: Any, context: Any) -> Any:
        attribute = int(getattr(request, "attribute_raw", 0))
        self.calls.append(f"{rpc} {attribute:#x}" if attribute else rpc)
        if rpc == "ReadCounterU32Ex":
            return self._read(request, context)
        if self.calls[-1] in self.refuses:
            context.set_trailing_metadata((("ni-error", str(self.refuses[self.calls[-1]])),))
            return context.abort(grpc.StatusCode.UNKNOWN, "refused")
        response = getattr(messages, f"{rpc}Response")()
        for name, value in ANSWERS.get(self.calls[-1], {}).items():
            setattr(response, name, value)
        return response

    def _read(self, request: Any, context: Any) -> Any:
        assert request.timeout == 0
        step = self.reads.pop(0) if self.reads else (-200284, list[int]())
        if isinstance(step, int):
            context.set_trailing_metadata((("ni-error", str(step)), ("ni-samps-per-chan-read", "2")))
            return context.abort(grpc.StatusCode.UNKNOWN, "aborted")
        status, samples = step
        return messages.ReadCounterU32ExResponse(status=status, read_array=samples, samps_per_chan_read=len(samples))


@pytest.fixture
def server() -> Iterator[SimpleNamespace]:
    servicer = Server()
    running: Any = grpc.server(ThreadPoolExecutor(2))
    stubs.add_NiDAQmxServicer_to_server(servicer, running)
    port = running.add_insecure_port("127.0.0.1:0")
    running.start()
    channel: Any = grpc.insecure_channel(f"127.0.0.1:{port}")
    yield SimpleNamespace(servicer=servicer, options=nidaqmx.GrpcSessionOptions(channel, ""), running=running)
    channel.close()
    running.stop(None).wait()


def system_on(server: SimpleNamespace) -> NiSystem:
    return open_system(server.options)


def test_a_board_is_asked_for_product_serial_clock_and_width(server: SimpleNamespace) -> None:
    system = system_on(server)
    assert system.boards() == ("Dev1", "Dev2")
    assert system.board("Dev1") == NiBoardFacts("PCIe-6323", "1A2B", False, True, 32, 100e6, ("ctr0", "ctr1"))
    assert system.version.endswith("NI-DAQmx 24.0.0")


@pytest.mark.parametrize("code", [-200452, -200197])
def test_a_board_without_the_property_of_a_sample_clock_has_none(server: SimpleNamespace, code: int) -> None:
    """As on a USB-6002 or USB-6008, which count only when they are asked."""
    server.servicer.refuses["GetDeviceAttributeBool 0x299e"] = code
    assert not system_on(server).board("Dev1").sample_clocked_counting
    server.servicer.refuses["GetDeviceAttributeBool 0x299e"] = -201003
    with pytest.raises(NiFault, match=r"refused|-201003"):
        system_on(server).board("Dev1")


def test_a_task_is_configured_by_the_calls_of_the_fact_sheet(server: SimpleNamespace) -> None:
    system = system_on(server)
    server.servicer.calls.clear()
    task = system.edge_count(COUNT)
    task.start()
    assert task.available() == 3
    assert task.acquired() == 4
    task.stop()
    task.close()
    calls = [call for call in server.servicer.calls if not call.startswith(("GetSystemInfo", "GetTask", "Self"))]
    assert calls == [
        "CreateTask",
        "CreateCICountEdgesChan",
        "SetChanAttributeString 0x18c7",
        "SetChanAttributeBool 0x21ac",
        "CfgSampClkTiming",
        *[call for call in calls if call.startswith("SetTiming")],
        "SetTrigAttributeInt32 0x1414",
        "SetTrigAttributeString 0x1417",
        "SetTrigAttributeInt32 0x1415",
        "SetBufferAttributeUInt32 0x186c",
        "SetReadAttributeInt32 0x1211",
        "StartTask",
        "GetReadAttributeUInt32 0x1223",
        "GetReadAttributeUInt64 0x192a",
        "StopTask",
        "ClearTask",
    ]
    assert len([call for call in calls if call.startswith("SetTiming")]) == 2


def test_a_read_gives_samples_and_a_partial_one_is_no_fault(server: SimpleNamespace) -> None:
    task = system_on(server).edge_count(COUNT)
    server.servicer.reads = [(0, [7, 8]), (-200284, [9])]
    whole, partial, none = task.read(2), task.read(5), task.read(1)
    assert (whole.samples.tolist(), whole.fault) == ([7, 8], None)
    assert (partial.samples.tolist(), partial.fault) == ([9], None)
    assert (none.samples.tolist(), none.fault) == ([], None)
    task.close()


def test_a_failed_read_keeps_the_samples_that_came_and_trusts_none_that_did_not(server: SimpleNamespace) -> None:
    task = system_on(server).edge_count(COUNT)
    server.servicer.reads = [(-200361, [7, 8]), -200279]
    status, aborted = task.read(5), task.read(5)
    assert status.samples.tolist() == [7, 8]
    assert status.fault is not None
    assert status.fault.code == -200361
    assert aborted.samples.tolist() == []
    assert aborted.fault is not None
    assert aborted.fault.code == -200279
    task.close()


def test_a_whole_run_through_the_real_client_package(server: SimpleNamespace) -> None:
    context = BenchContext(clock=ScriptClock(), transport=server.options)
    with open_counter(NiSettings(edge_counter=None), context) as counter:
        assert counter.identity.simulated
        server.servicer.reads = [(0, [4294967295, 3, 5]), (-200361, [6])]
        counter.arm(CounterRun(n_bins=5, period_s=50e-6, latency_s=100e-6))
        assert counter.read(0.1).counts.tolist() == [4, 2]
        assert counter.read(0.1).counts.tolist() == [1]
        with pytest.raises(CounterOverrun, match="INPUT_FIFO_OVERFLOW_2"):
            counter.read(0.1)
        assert counter.disarm().bins_closed == 3


def test_a_server_that_goes_away_is_a_disconnection(server: SimpleNamespace) -> None:
    context = BenchContext(clock=ScriptClock(), transport=server.options)
    counter = open_counter(NiSettings(edge_counter=None), context)
    server.running.stop(None).wait()
    with pytest.raises(DeviceDisconnected, match="UNAVAILABLE"):
        counter.arm(CounterRun(n_bins=5, period_s=50e-6))


def test_a_transport_that_is_not_ni_grpc_is_refused() -> None:
    with pytest.raises(InputError, match="a transport of type str; expected a nidaqmx"):
        open_counter(NiSettings(), BenchContext(transport="COM3"))


def test_without_the_runtime_the_driver_says_what_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    def absent() -> None:
        raise nidaqmx.errors.DaqNotFoundError("Could not find an installation of NI-DAQmx.")

    monkeypatch.setattr("nidaqmx.system.System.local", absent)
    told = availability()
    assert not told.ready
    assert "Could not find an installation of NI-DAQmx. To do: install NI-DAQmx" in told.missing
    assert probe() == ()
    with pytest.raises(DriverUnavailable, match=r"ni\.com"):
        open_counter(NiSettings(), BenchContext())


def test_without_the_package_the_driver_says_what_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> None:
        raise ImportError(name="nidaqmx")

    monkeypatch.setattr("drivers.ni.tasks.import_module", missing)
    assert "no module 'nidaqmx'" in availability().missing
    with pytest.raises(NiFault):
        open_system()
