"""The remote calls of NI's gRPC device server (session.proto, nidaqmx.proto), as far as edge counting needs them.

The one place that touches the generated stubs, which are only partly typed.
"""

# ruff: noqa: N802, D102  (the calls have the names of the remote service, which documents them)

import functools
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager
from typing import Any

import grpc
from nidaqmx._stubs import nidaqmx_pb2 as pb
from nidaqmx._stubs import nidaqmx_pb2_grpc
from session_pb2 import Session

from sim_backends.wire.ni.board import EmulatedNiBoard, Samples
from sim_backends.wire.ni.errors import NiError, ServerGone, text_of

_Servicer: Any = nidaqmx_pb2_grpc.NiDAQmxServicer

_TASK_GROUPS = ("Task", "Chan", "Timing", "Trig", "Buffer", "Read")
_KINDS = ("Bool", "Double", "Int32", "String", "UInt32", "UInt64")


def _rpc(method: Callable[..., Any]) -> Callable[..., Any]:
    """Write a call down, let faults at it, and turn errors into trailing metadata."""

    @functools.wraps(method)
    def answer(self: "NiService", request: Any, context: grpc.ServicerContext) -> Any:
        with self.answering(method.__name__, request, context):
            return method(self, request)

    return answer


class NiService(_Servicer):  # type: ignore[misc]
    """``NiDAQmxServicer`` for an emulated board. What is not here answers UNIMPLEMENTED."""

    def __init__(self, board: EmulatedNiBoard) -> None:
        self.board = board
        self.transcript: list[tuple[str, Any]] = []
        """Name and request of each call, in order, for tests."""

    @contextmanager
    def answering(self, rpc: str, request: Any, context: grpc.ServicerContext) -> Generator[None]:
        """Note a call, and abort it as the device server does where the board refuses (4.7)."""
        self.transcript.append((rpc, request))
        try:
            self.board.called(rpc)
            yield
        except NiError as error:
            metadata = [("ni-error", str(error.code))]
            if error.manner == "metadata":
                metadata.append(("ni-samps-per-chan-read", "0"))
            context.set_trailing_metadata(tuple(metadata))
            context.abort(grpc.StatusCode.UNKNOWN, str(error))
        except ServerGone:
            context.abort(grpc.StatusCode.UNAVAILABLE, "the server is gone")

    @_rpc
    def GetErrorString(self, request: Any) -> Any:
        return pb.GetErrorStringResponse(error_string=text_of(request.error_code))

    @_rpc
    def CreateTask(self, request: Any) -> Any:
        name = self.board.create(request.session_name)
        return pb.CreateTaskResponse(task=Session(name=name), new_session_initialized=True)

    @_rpc
    def ClearTask(self, request: Any) -> Any:
        self.board.clear(request.task.name)
        return pb.ClearTaskResponse()

    @_rpc
    def StartTask(self, request: Any) -> Any:
        self.board.start(request.task.name)
        return pb.StartTaskResponse()

    @_rpc
    def StopTask(self, request: Any) -> Any:
        self.board.stop(request.task.name)
        return pb.StopTaskResponse()

    @_rpc
    def TaskControl(self, request: Any) -> Any:
        self.board.control(request.task.name, request.action_raw or request.action)
        return pb.TaskControlResponse()

    @_rpc
    def IsTaskDone(self, request: Any) -> Any:
        return pb.IsTaskDoneResponse(is_task_done=self.board.is_done(request.task.name))

    @_rpc
    def WaitUntilTaskDone(self, request: Any) -> Any:
        self.board.wait_until_done(request.task.name, request.time_to_wait)
        return pb.WaitUntilTaskDoneResponse()

    @_rpc
    def CreateCICountEdgesChan(self, request: Any) -> Any:
        self.board.add_counter(
            request.task.name,
            request.counter,
            request.name_to_assign_to_channel,
            edge=request.edge_raw,
            initial=request.initial_count,
            direction=request.count_direction_raw,
        )
        return pb.CreateCICountEdgesChanResponse()

    @_rpc
    def CfgSampClkTiming(self, request: Any) -> Any:
        self.board.clock(
            request.task.name,
            request.source,
            request.rate,
            edge=request.active_edge_raw,
            mode=request.sample_mode_raw,
            samples=request.samps_per_chan,
        )
        return pb.CfgSampClkTimingResponse()

    def _read(self, request: Any, response: Any, n: int) -> Any:
        values, status = self.board.read(request.task.name, n, request.timeout)
        return response(status=status, read_array=self._listed(values), samps_per_chan_read=len(values))

    @staticmethod
    def _listed(values: Samples) -> list[int]:
        return [int(value) for value in values]

    @_rpc
    def ReadCounterU32Ex(self, request: Any) -> Any:
        return self._read(request, pb.ReadCounterU32ExResponse, request.num_samps_per_chan)

    @_rpc
    def ReadCounterF64Ex(self, request: Any) -> Any:
        return self._read(request, pb.ReadCounterF64ExResponse, request.num_samps_per_chan)

    @_rpc
    def ReadCounterScalarU32(self, request: Any) -> Any:
        return pb.ReadCounterScalarU32Response(value=self._scalar(request))

    @_rpc
    def ReadCounterScalarF64(self, request: Any) -> Any:
        return pb.ReadCounterScalarF64Response(value=self._scalar(request))

    def _scalar(self, request: Any) -> int:
        values, status = self.board.read(request.task.name, 1, request.timeout)
        if status:
            raise NiError(status, manner="metadata")
        return int(values[0])

    def RegisterEveryNSamplesEvent(self, request: Any, context: grpc.ServicerContext) -> Iterator[Any]:
        with self.answering("RegisterEveryNSamplesEvent", request, context):
            event = self.board.every_n(request.task.name, request.n_samples)
        context.add_callback(event.close)
        # The client blocks until the first metadata are there.
        context.send_initial_metadata(())
        while event.queue.get():
            yield pb.RegisterEveryNSamplesEventResponse(
                every_n_samples_event_type_raw=request.every_n_samples_event_type_raw, n_samples=request.n_samples
            )

    @_rpc
    def UnregisterEveryNSamplesEvent(self, request: Any) -> Any:
        self.board.no_events(request.task.name)
        return pb.UnregisterEveryNSamplesEventResponse()


def _told(response: Any, kind: str, value: Any) -> Any:
    return response(value_raw=value) if kind.startswith("Int32") else response(value=value)


def _getter(rpc: str, group: str, kind: str) -> Callable[..., Any]:
    def get(self: NiService, request: Any) -> Any:
        match group:
            case "SystemInfo":
                value: Any = self.board.system(request.attribute_raw)
            case "Device":
                value = self.board.device(request.device_name, request.attribute_raw)
            case _:
                value = self.board.get(request.task.name, group, request.attribute_raw)
        return _told(getattr(pb, f"{rpc}Response"), kind, value)

    get.__name__ = rpc
    return _rpc(get)


def _setter(rpc: str, group: str, kind: str) -> Callable[..., Any]:
    def put(self: NiService, request: Any) -> Any:
        value = request.value_raw if kind == "Int32" else request.value
        self.board.set(request.task.name, group, request.attribute_raw, value)
        return getattr(pb, f"{rpc}Response")()

    put.__name__ = rpc
    return _rpc(put)


def _resetter(rpc: str, group: str) -> Callable[..., Any]:
    def reset(self: NiService, request: Any) -> Any:
        self.board.reset(request.task.name, group, request.attribute_raw)
        return getattr(pb, f"{rpc}Response")()

    reset.__name__ = rpc
    return _rpc(reset)


def _add_attribute_calls() -> None:
    """The attribute calls are one pattern: group and type in the name."""
    for group in (*_TASK_GROUPS, "SystemInfo", "Device"):
        for kind in (*_KINDS, "Int32Array"):
            for verb, made in (("Get", _getter), ("Set", _setter)):
                rpc = f"{verb}{group}Attribute{kind}"
                if hasattr(_Servicer, rpc):
                    setattr(NiService, rpc, made(rpc, group, kind))
        reset = f"Reset{group}Attribute"
        if hasattr(_Servicer, reset):
            setattr(NiService, reset, _resetter(reset, group))


_add_attribute_calls()
