"""The one place that touches the ``nidaqmx`` package: a handful of calls, typed, with NI's exceptions turned into ``NiFault``.

``nidaqmx`` is imported on first use, since it is an extra and its C runtime may be missing. Through ``NiSystem`` and
``NiTask`` the driver can be run on anything that behaves like them.
"""

from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import version
from typing import Any, Literal, Protocol

import numpy as np
from numpy.typing import NDArray

from drivers.h10682.detector import NAME
from drivers.ni.errors import NO_SUCH_PROPERTY, NOT_YET_AVAILABLE, NiFault
from protocols import InputError

Edge = Literal["rising", "falling"]

_UNTOUCHED = 0xFFFFFFFF


@dataclass(frozen=True)
class NiBoardFacts:
    """What a board says about itself (fact sheet, section 4.1, device queries)."""

    product: str
    serial: str
    simulated: bool
    sample_clocked_counting: bool
    counter_bits: int
    max_timebase_hz: float
    counters: tuple[str, ...]


@dataclass(frozen=True)
class EdgeCount:
    """One buffered edge count: what is counted, and by which edges it is sampled."""

    counter: str
    source: str
    clock: str
    clock_edge: Edge
    max_rate_hz: float
    buffer_samples: int
    prevent_duplicates: bool
    clock_filter_s: float | None = None
    arm: str | None = None


@dataclass(frozen=True, eq=False)
class NiRead:
    """Samples that are good, and what broke after them."""

    samples: NDArray[np.uint32]
    fault: NiFault | None = None


class NiTask(Protocol):
    """One counter task. Every method but ``read`` raises ``NiFault``."""

    def start(self) -> None:
        """Arm the counter."""
        ...

    def available(self) -> int:
        """Samples that wait in the buffer."""
        ...

    def read(self, n: int) -> NiRead:
        """Take up to ``n`` samples without waiting; what is not there yet is no fault."""
        ...

    def acquired(self) -> int:
        """Samples since the start, read or not: the edges of the clock."""
        ...

    def doubtful(self) -> int:
        """Samples that the board itself calls possibly invalid."""
        ...

    def stop(self) -> None:
        """Disarm the counter."""
        ...

    def close(self) -> None:
        """Give the counter back."""
        ...


class NiSystem(Protocol):
    """NI-DAQmx on this machine, or behind a gRPC channel."""

    @property
    def version(self) -> str:
        """Version of the package and of the runtime."""
        ...

    def boards(self) -> tuple[str, ...]:
        """Names of the boards."""
        ...

    def board(self, name: str) -> NiBoardFacts:
        """What the board says about itself."""
        ...

    def edge_count(self, count: EdgeCount) -> NiTask:
        """A configured task, not started."""
        ...


def open_system(transport: object | None = None) -> NiSystem:
    """NI-DAQmx through ``transport`` (a ``nidaqmx.GrpcSessionOptions``), or the local runtime where it is None.

    Raises:
        NiFault: the package is not installed.
        InputError: the transport is something else.
    """
    try:
        nidaqmx: Any = import_module("nidaqmx")
    except ImportError as error:
        raise NiFault(f"no module {error.name!r}") from error
    if transport is not None and not hasattr(transport, "grpc_channel"):
        raise InputError(
            device=NAME,
            saw=f"a transport of type {type(transport).__name__}",
            expected="a nidaqmx.GrpcSessionOptions",
            remedy="name a transport that is made for NI-DAQmx in bench.toml",
        )
    return _Nidaqmx(nidaqmx, transport)


@contextmanager
def ni_faults() -> Generator[None]:
    """Turn what the ``nidaqmx`` package raises into ``NiFault``."""
    errors: Any = import_module("nidaqmx.errors")
    try:
        yield
    except errors.DaqError as error:
        read = int(getattr(error, "samps_per_chan_read", 0))
        raise NiFault(str(error), int(error.error_code), samples_read=read) from error
    except errors.RpcError as error:
        rpc_code = str(getattr(error.rpc_code, "name", error.rpc_code))
        raise NiFault(str(error.description), rpc_code=rpc_code) from error
    except errors.Error as error:
        raise NiFault(str(error)) from error


class _Nidaqmx:
    def __init__(self, nidaqmx: Any, transport: object | None) -> None:
        self._nidaqmx = nidaqmx
        self._transport = transport
        system: Any = import_module("nidaqmx.system").System
        with ni_faults():
            self._system: Any = system.local() if transport is None else system.remote(transport)

    @property
    def version(self) -> str:
        with ni_faults():
            runtime: Any = self._system.driver_version
            return (
                f"nidaqmx {version('nidaqmx')}, "
                f"NI-DAQmx {runtime.major_version}.{runtime.minor_version}.{runtime.update_version}"
            )

    def boards(self) -> tuple[str, ...]:
        with ni_faults():
            return tuple(str(name) for name in self._system.devices.device_names)

    def board(self, name: str) -> NiBoardFacts:
        with ni_faults():
            device: Any = self._system.devices[name]
            return NiBoardFacts(
                product=str(device.product_type),
                serial=self._serial(device),
                simulated=bool(device.is_simulated),
                sample_clocked_counting=self._sample_clocked(device),
                counter_bits=int(device.ci_max_size),
                max_timebase_hz=float(device.ci_max_timebase),
                counters=tuple(str(name).rpartition("/")[2] for name in device.ci_physical_chans.channel_names),
            )

    def edge_count(self, count: EdgeCount) -> NiTask:
        with ni_faults():
            task: Any = self._nidaqmx.Task(grpc_options=self._transport)
            try:
                return _CounterTask(task, count)
            except BaseException:
                task.close()
                raise

    def _sample_clocked(self, device: Any) -> bool:
        """Whether counters take a sample clock; a board without such a property has none."""
        try:
            with ni_faults():
                return bool(device.ci_samp_clk_supported)
        except NiFault as fault:
            if fault.code not in NO_SUCH_PROPERTY:
                raise
            return False

    def _serial(self, device: Any) -> str:
        """The serial number is for the record only: a board or server that has none does not stop a run."""
        try:
            with ni_faults():
                return f"{int(device.serial_num):X}"
        except NiFault:
            return ""


class _CounterTask:
    def __init__(self, task: Any, count: EdgeCount) -> None:
        constants: Any = import_module("nidaqmx.constants")
        edge = constants.Edge.FALLING if count.clock_edge == "falling" else constants.Edge.RISING
        channel = task.ci_channels.add_ci_count_edges_chan(
            count.counter,
            edge=constants.Edge.RISING,
            initial_count=0,
            count_direction=constants.CountDirection.COUNT_UP,
        )
        channel.ci_count_edges_term = count.source
        channel.ci_dup_count_prevention = count.prevent_duplicates
        task.timing.cfg_samp_clk_timing(
            count.max_rate_hz,
            source=count.clock,
            active_edge=edge,
            sample_mode=constants.AcquisitionType.CONTINUOUS,
            samps_per_chan=count.buffer_samples,
        )
        if count.clock_filter_s is not None:
            task.timing.samp_clk_dig_fltr_min_pulse_width = count.clock_filter_s
            task.timing.samp_clk_dig_fltr_enable = True
        if count.arm is not None:
            arm = task.triggers.arm_start_trigger
            arm.trig_type = constants.TriggerType.DIGITAL_EDGE
            arm.dig_edge_src = count.arm
            arm.dig_edge_edge = constants.Edge.RISING
        task.in_stream.input_buf_size = count.buffer_samples
        task.in_stream.overwrite = constants.OverwriteMode.DO_NOT_OVERWRITE_UNREAD_SAMPLES
        readers: Any = import_module("nidaqmx.stream_readers")
        self._task = task
        self._channel: Any = channel
        self._reader: Any = readers.CounterReader(task.in_stream)
        self._reader.verify_array_shape = False

    def start(self) -> None:
        with ni_faults():
            self._task.start()

    def available(self) -> int:
        with ni_faults():
            return int(self._task.in_stream.avail_samp_per_chan)

    def read(self, n: int) -> NiRead:
        samples = np.full(n, _UNTOUCHED, np.uint32)
        try:
            with ni_faults():
                got = int(self._reader.read_many_sample_uint32(samples, n, timeout=0.0))
        except NiFault as fault:
            good = samples[: fault.samples_read]
            # A server that aborts the call names samples that it never sent.
            good = samples[:0] if np.all(good == _UNTOUCHED) else good
            return NiRead(good, None if fault.code == NOT_YET_AVAILABLE else fault)
        return NiRead(samples[:got])

    def acquired(self) -> int:
        with ni_faults():
            return int(self._task.in_stream.total_samp_per_chan_acquired)

    def doubtful(self) -> int:
        with ni_faults():
            return int(self._channel.ci_num_possibly_invalid_samps)

    def stop(self) -> None:
        with ni_faults():
            self._task.stop()

    def close(self) -> None:
        with ni_faults():
            self._task.close()
