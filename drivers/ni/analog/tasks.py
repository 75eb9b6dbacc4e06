"""The calls of ``nidaqmx`` that sample two analogue inputs on the board's own clock."""

from dataclasses import dataclass
from importlib import import_module
from typing import Any, Literal, Protocol

import numpy as np

from drivers.h10682.detector import NAME
from drivers.ni.errors import NOT_YET_AVAILABLE, NiFault
from drivers.ni.tasks import ni_faults
from protocols import Floats, InputError


@dataclass(frozen=True)
class AnalogInput:
    """Two inputs, sampled together."""

    channels: tuple[str, str]
    """Full names, the detector's first."""

    terminal: Literal["default", "rse", "nrse", "diff"]
    range_v: float
    rate_hz: float
    buffer_samples: int


@dataclass(frozen=True)
class AnalogFacts:
    """What a board says about itself."""

    product: str
    simulated: bool
    highest_rate_hz: float
    """Samples a second and channel, with two channels."""


@dataclass(frozen=True, eq=False)
class AnalogRead:
    """Samples that are good, and what broke after them."""

    samples_v: Floats
    """``(2, n)``."""

    fault: NiFault | None = None


class AnalogTask(Protocol):
    """One task. Every method but ``read`` raises ``NiFault``."""

    @property
    def rate_hz(self) -> float:
        """Rate that the board really samples at."""
        ...

    def start(self) -> None:
        """Begin to sample."""
        ...

    def available(self) -> int:
        """Samples a channel that wait in the buffer."""
        ...

    def read(self, n: int) -> AnalogRead:
        """Take ``n`` samples a channel that wait."""
        ...

    def stop(self) -> None:
        """Stop."""
        ...

    def close(self) -> None:
        """Give the inputs back."""
        ...


class AnalogSystem:
    """NI-DAQmx on this machine, or behind a gRPC channel."""

    def __init__(self, transport: object | None) -> None:
        """Open it.

        Args:
            transport: a ``nidaqmx.GrpcSessionOptions``, or None for the local runtime.

        Raises:
            NiFault: the package is not installed, or the runtime is missing.
            InputError: the transport is something else.
        """
        try:
            self._nidaqmx: Any = import_module("nidaqmx")
        except ImportError as error:
            raise NiFault(f"no module {error.name!r}") from error
        if transport is not None and not hasattr(transport, "grpc_channel"):
            raise InputError(
                device=NAME,
                saw=f"a transport of type {type(transport).__name__}",
                expected="a nidaqmx.GrpcSessionOptions",
                remedy="name a transport that is made for NI-DAQmx in bench.toml",
            )
        self._transport = transport
        system: Any = import_module("nidaqmx.system").System
        with ni_faults():
            self._system: Any = system.local() if transport is None else system.remote(transport)

    def board(self, name: str) -> AnalogFacts:
        """Ask a board.

        Raises:
            NiFault: no such board, or it does not tell.
        """
        with ni_faults():
            device: Any = self._system.devices[name]
            together = bool(device.ai_simultaneous_sampling_supported)
            return AnalogFacts(
                product=str(device.product_type),
                simulated=bool(device.is_simulated),
                highest_rate_hz=float(device.ai_max_multi_chan_rate) / (1 if together else 2),
            )

    def sample(self, asked: AnalogInput) -> AnalogTask:
        """Give a configured task, not started.

        Raises:
            NiFault: the board does not take it.
        """
        with ni_faults():
            task: Any = self._nidaqmx.Task(grpc_options=self._transport)
            try:
                return _Task(task, asked)
            except BaseException:
                task.close()
                raise


class _Task:
    def __init__(self, task: Any, asked: AnalogInput) -> None:
        constants: Any = import_module("nidaqmx.constants")
        terminals = constants.TerminalConfiguration
        terminal = {"default": terminals.DEFAULT, "rse": terminals.RSE, "nrse": terminals.NRSE, "diff": terminals.DIFF}
        for channel in asked.channels:
            task.ai_channels.add_ai_voltage_chan(
                channel,
                terminal_config=terminal[asked.terminal],
                min_val=-asked.range_v,
                max_val=asked.range_v,
            )
        task.timing.cfg_samp_clk_timing(
            asked.rate_hz, sample_mode=constants.AcquisitionType.CONTINUOUS, samps_per_chan=asked.buffer_samples
        )
        task.in_stream.overwrite = constants.OverwriteMode.DO_NOT_OVERWRITE_UNREAD_SAMPLES
        readers: Any = import_module("nidaqmx.stream_readers")
        self._task = task
        self._reader: Any = readers.AnalogMultiChannelReader(task.in_stream)
        self.rate_hz = float(task.timing.samp_clk_rate)

    def start(self) -> None:
        with ni_faults():
            self._task.start()

    def available(self) -> int:
        with ni_faults():
            return int(self._task.in_stream.avail_samp_per_chan)

    def read(self, n: int) -> AnalogRead:
        samples = np.zeros((2, n))
        if n == 0:
            return AnalogRead(samples)
        try:
            with ni_faults():
                got = int(self._reader.read_many_sample(samples, n, timeout=0.0))
        except NiFault as fault:
            return AnalogRead(samples[:, :0], None if fault.code == NOT_YET_AVAILABLE else fault)
        return AnalogRead(samples[:, :got])

    def stop(self) -> None:
        with ni_faults():
            self._task.stop()

    def close(self) -> None:
        with ni_faults():
            self._task.close()
