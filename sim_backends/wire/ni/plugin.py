"""Entry point of the emulated NI board: ``transport = "ni-emulator"`` under ``[counter]``."""

from protocols import BenchContext, DriverUnavailable, TransportPlugin
from sim_backends.wire.ni.settings import NiEmulatorSettings
from sim_backends.wire.seen_edges import photon_bench_of

_NAME = "ni-emulator"


def open_emulator(settings: NiEmulatorSettings, context: BenchContext) -> object:
    """Start the emulated board.

    Returns:
        A ``NiEmulator``: a ``nidaqmx.GrpcSessionOptions`` that is also a context manager which stops its server.

    Raises:
        InputError: no optical bench, or one that does not count photons.
        DriverUnavailable: the nidaqmx package or its gRPC extra is not installed.
    """
    bench = photon_bench_of(context, _NAME)
    try:
        from sim_backends.wire.ni.emulator import NiEmulator  # noqa: PLC0415  (an extra: only who asks for it needs it)
    except ImportError as error:
        raise DriverUnavailable(
            device=_NAME,
            saw=f"no Python package '{error.name}'",
            expected="nidaqmx with its gRPC extra, 1.7 or newer",
            remedy="install kinopix[ni]",
        ) from error
    return NiEmulator(settings, bench)


plugin = TransportPlugin(
    summary="emulated NI X-series board behind a gRPC device server", settings=NiEmulatorSettings, open=open_emulator
)
"""Found as ``kinopix.transports: ni-emulator``."""
