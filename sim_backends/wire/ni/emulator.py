"""The server on a local port, and the session options by which a client finds it."""

import threading
from concurrent.futures import ThreadPoolExecutor
from typing import Any, Self

import grpc
import nidaqmx
from nidaqmx._stubs.nidaqmx_pb2_grpc import add_NiDAQmxServicer_to_server

from sim_backends.bench import OpticalBench
from sim_backends.wire.ni.board import EmulatedNiBoard
from sim_backends.wire.ni.service import NiService
from sim_backends.wire.ni.settings import NiEmulatorSettings

_GrpcSessionOptions: Any = nidaqmx.GrpcSessionOptions
_add_servicer: Any = add_NiDAQmxServicer_to_server


class NiEmulator(_GrpcSessionOptions):  # type: ignore[misc]
    """An emulated NI board behind a gRPC server on 127.0.0.1, as ``nidaqmx.GrpcSessionOptions``.

    Give it to ``nidaqmx.Task(grpc_options=...)`` and ``nidaqmx.system.System.remote(...)``. As a context manager it closes
    channel and server; ``close`` does the same and may be called twice.
    """

    def __init__(self, settings: NiEmulatorSettings, bench: OpticalBench) -> None:
        """Start the server and connect to it."""
        self.board = EmulatedNiBoard(settings, bench)
        self.service = NiService(self.board)
        self._workers = ThreadPoolExecutor(max_workers=16, thread_name_prefix="ni-emulator")
        self._server = grpc.server(self._workers)
        _add_servicer(self.service, self._server)
        port = self._server.add_insecure_port("127.0.0.1:0")
        self.address = f"127.0.0.1:{port}"
        """Where the server listens."""
        self._closing = threading.Lock()
        self._closed = False
        self._server.start()
        # The server is in this process: a proxy that the environment names for other hosts has no part in it.
        options = [("grpc.enable_http_proxy", 0)]
        super().__init__(grpc.insecure_channel(self.address, options), "")  # pyright: ignore[reportUnknownMemberType]

    def close(self) -> None:
        """Close the channel and stop the server."""
        with self._closing:
            if self._closed:
                return
            self._closed = True
        self.board.close()
        self.grpc_channel.close()
        self._server.stop(None).wait()
        self._workers.shutdown()

    def __enter__(self) -> Self:
        """Give the open emulator."""
        return self

    def __exit__(self, *exc: object) -> None:
        """Close it."""
        self.close()
