"""The remote calls of NI's gRPC device server that sampling two analogue inputs needs, and the server."""

# ruff: noqa: N802, D102  (the calls have the names of the remote service, which documents them)

import threading
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field
from functools import wraps
from typing import Any, Self

import grpc
import nidaqmx
from nidaqmx._stubs import nidaqmx_pb2 as pb
from nidaqmx._stubs import nidaqmx_pb2_grpc
from session_pb2 import Session

from sim_backends.bench import OpticalBench
from sim_backends.wire.ni_analog.settings import NiAnalogEmulatorSettings
from sim_backends.wire.ni_analog.signal import Signal

_Servicer: Any = nidaqmx_pb2_grpc.NiDAQmxServicer
_GrpcSessionOptions: Any = nidaqmx.GrpcSessionOptions
_add_servicer: Any = nidaqmx_pb2_grpc.add_NiDAQmxServicer_to_server

_RESERVED, _OVERRUN, _NO_DEVICE, _TOO_FAST, _NOT_THERE = -50103, -200279, -200220, -200081, -200284
_UNSUPPORTED, _GONE = -200452, -201003
_TEXTS = {
    _RESERVED: "The specified resource is reserved. The operation could not be completed as specified.",
    _OVERRUN: "The application is not able to keep up with the hardware acquisition.",
    _NO_DEVICE: "Device identifier is invalid.",
    _TOO_FAST: "Sample rate exceeds the maximum sample rate for the number of channels specified.",
    _NOT_THERE: "Some or all of the samples requested have not yet been acquired.",
    _GONE: "Device cannot be accessed. Possible causes: device is no longer present in the system.",
    _UNSUPPORTED: "Specified property is not supported by the device or is not applicable to the task.",
}

_PRODUCT_TYPE, _IS_SIMULATED, _MAX_MULTI, _SIMULTANEOUS, _DEVICES = 0x0631, 0x22CA, 0x298D, 0x298F, 0x193B
_TASK_NAME, _TASK_CHANNELS, _TASK_NUM_CHANNELS = 0x1276, 0x1273, 0x2181
_AVAILABLE, _RATE, _NUM_CHANNELS, _CHANNELS = 0x1223, 0x1344, 0x217B, 0x1823


class _Refused(Exception):
    """An error of the board's."""

    def __init__(self, code: int) -> None:
        super().__init__(_TEXTS[code])
        self.code = code


@dataclass
class _Task:
    channels: list[str] = field(default_factory=list[str])
    rate_hz: float = 1000.0
    signal: Signal | None = None


def _rpc(method: Callable[..., Any]) -> Callable[..., Any]:
    @wraps(method)
    def answer(self: "NiAnalogService", request: Any, context: grpc.ServicerContext) -> Any:
        with self.lock:
            try:
                if self.gone and method.__name__ != "GetErrorString":
                    raise _Refused(_GONE)
                return method(self, request)
            except _Refused as error:
                context.set_trailing_metadata((("ni-error", str(error.code)), ("ni-samps-per-chan-read", "0")))
                context.abort(grpc.StatusCode.UNKNOWN, str(error))

    return answer


class NiAnalogService(_Servicer):  # type: ignore[misc]
    """``NiDAQmxServicer`` for two analogue inputs. What is not here answers UNIMPLEMENTED."""

    def __init__(self, settings: NiAnalogEmulatorSettings, bench: OpticalBench) -> None:
        self.lock = threading.RLock()
        self.gone = False
        self._settings, self._bench = settings, bench
        self._tasks: dict[str, _Task] = {}
        self._made = self._reads = 0

    @_rpc
    def GetErrorString(self, request: Any) -> Any:
        return pb.GetErrorStringResponse(error_string=_TEXTS.get(request.error_code, ""))

    @_rpc
    def CreateTask(self, request: Any) -> Any:
        self._made += 1
        name = request.session_name or f"task{self._made}"
        self._tasks[name] = _Task()
        return pb.CreateTaskResponse(task=Session(name=name), new_session_initialized=True)

    @_rpc
    def GetTaskAttributeString(self, request: Any) -> Any:
        task = self._tasks[request.task.name]
        values = {_TASK_NAME: request.task.name, _TASK_CHANNELS: ", ".join(task.channels)}
        return pb.GetTaskAttributeStringResponse(value=_known(values, request))

    @_rpc
    def GetTaskAttributeUInt32(self, request: Any) -> Any:
        task = self._tasks[request.task.name]
        return pb.GetTaskAttributeUInt32Response(value=_known({_TASK_NUM_CHANNELS: len(task.channels)}, request))

    @_rpc
    def ClearTask(self, request: Any) -> Any:
        self._tasks.pop(request.task.name, None)
        return pb.ClearTaskResponse()

    @_rpc
    def CreateAIVoltageChan(self, request: Any) -> Any:
        device, _, channel = request.physical_channel.partition("/")
        if device != self._settings.device or channel not in {"ai0", "ai1"}:
            raise _Refused(_NO_DEVICE)
        self._tasks[request.task.name].channels.append(request.physical_channel)
        return pb.CreateAIVoltageChanResponse()

    @_rpc
    def CfgSampClkTiming(self, request: Any) -> Any:
        self._tasks[request.task.name].rate_hz = request.rate
        return pb.CfgSampClkTimingResponse()

    @_rpc
    def StartTask(self, request: Any) -> Any:
        task, settings = self._tasks[request.task.name], self._settings
        if settings.reserved:
            raise _Refused(_RESERVED)
        if task.rate_hz * (1 if settings.simultaneous else len(task.channels)) > settings.max_rate_hz:
            raise _Refused(_TOO_FAST)
        task.signal = Signal(settings, self._bench, task.rate_hz)
        return pb.StartTaskResponse()

    @_rpc
    def StopTask(self, request: Any) -> Any:
        self._tasks[request.task.name].signal = None
        return pb.StopTaskResponse()

    @_rpc
    def ReadAnalogF64(self, request: Any) -> Any:
        signal = self._tasks[request.task.name].signal
        n = request.num_samps_per_chan
        self._reads += 1
        if self._settings.overrun_at_read is not None and self._reads > self._settings.overrun_at_read:
            raise _Refused(_OVERRUN)
        if self._settings.gone_at_read is not None and self._reads > self._settings.gone_at_read:
            self.gone = True
            raise _Refused(_GONE)
        if signal is None or n > signal.ready():
            raise _Refused(_NOT_THERE)
        light, sync = signal.take(n)
        return pb.ReadAnalogF64Response(read_array=[*light.tolist(), *sync.tolist()], samps_per_chan_read=n)

    @_rpc
    def SetReadAttributeInt32(self, request: Any) -> Any:
        del request
        return pb.SetReadAttributeInt32Response()

    @_rpc
    def GetReadAttributeUInt32(self, request: Any) -> Any:
        task = self._tasks[request.task.name]
        values = {
            _AVAILABLE: task.signal.ready() if task.signal else 0,
            _NUM_CHANNELS: len(task.channels),
        }
        return pb.GetReadAttributeUInt32Response(value=_known(values, request))

    @_rpc
    def GetReadAttributeString(self, request: Any) -> Any:
        task = self._tasks[request.task.name]
        return pb.GetReadAttributeStringResponse(value=_known({_CHANNELS: ", ".join(task.channels)}, request))

    @_rpc
    def GetTimingAttributeDouble(self, request: Any) -> Any:
        rate_hz = self._tasks[request.task.name].rate_hz
        return pb.GetTimingAttributeDoubleResponse(value=_known({_RATE: rate_hz}, request))

    @_rpc
    def GetDeviceAttributeString(self, request: Any) -> Any:
        self._named(request)
        return pb.GetDeviceAttributeStringResponse(value=_known({_PRODUCT_TYPE: self._settings.product}, request))

    @_rpc
    def GetDeviceAttributeBool(self, request: Any) -> Any:
        self._named(request)
        values = {_IS_SIMULATED: False, _SIMULTANEOUS: self._settings.simultaneous}
        return pb.GetDeviceAttributeBoolResponse(value=_known(values, request))

    @_rpc
    def GetDeviceAttributeDouble(self, request: Any) -> Any:
        self._named(request)
        return pb.GetDeviceAttributeDoubleResponse(value=_known({_MAX_MULTI: self._settings.max_rate_hz}, request))

    @_rpc
    def GetSystemInfoAttributeString(self, request: Any) -> Any:
        return pb.GetSystemInfoAttributeStringResponse(value=_known({_DEVICES: self._settings.device}, request))

    def _named(self, request: Any) -> None:
        if request.device_name != self._settings.device:
            raise _Refused(_NO_DEVICE)


def _known(values: dict[int, Any], request: Any) -> Any:
    if request.attribute_raw not in values:
        raise _Refused(_UNSUPPORTED)
    return values[request.attribute_raw]


class NiAnalogEmulator(_GrpcSessionOptions):  # type: ignore[misc]
    """An emulated board behind a gRPC server on 127.0.0.1, as ``nidaqmx.GrpcSessionOptions``; leaving it closes it."""

    def __init__(self, settings: NiAnalogEmulatorSettings, bench: OpticalBench) -> None:
        """Start the server and connect to it."""
        self._workers = ThreadPoolExecutor(max_workers=8, thread_name_prefix="ni-analog-emulator")
        self._server = grpc.server(self._workers)
        _add_servicer(NiAnalogService(settings, bench), self._server)
        port = self._server.add_insecure_port("127.0.0.1:0")
        self._closed = False
        self._server.start()
        limits = [("grpc.enable_http_proxy", 0), ("grpc.max_receive_message_length", -1)]
        channel = grpc.insecure_channel(f"127.0.0.1:{port}", limits)
        super().__init__(channel, "")  # pyright: ignore[reportUnknownMemberType]

    def close(self) -> None:
        """Close the channel and stop the server."""
        if self._closed:
            return
        self._closed = True
        self.grpc_channel.close()
        self._server.stop(None).wait()
        self._workers.shutdown()

    def __enter__(self) -> Self:
        """Give the open emulator."""
        return self

    def __exit__(self, *exc: object) -> None:
        """Close it."""
        self.close()
