"""Entry point: ``transport = "ni-analog-emulator"`` of a counter."""

from protocols import BenchContext, DriverUnavailable, TransportPlugin
from sim_backends.bench import bench_of
from sim_backends.wire.ni_analog.settings import NiAnalogEmulatorSettings

_NAME = "ni-analog-emulator"


def open_emulator(settings: NiAnalogEmulatorSettings, context: BenchContext) -> object:
    """Start the emulated board; gives a ``nidaqmx.GrpcSessionOptions`` that is a context manager too.

    Raises:
        InputError: no optical bench.
        DriverUnavailable: the nidaqmx package or its gRPC extra is not installed.
    """
    bench = bench_of(context, _NAME)
    try:
        from sim_backends.wire.ni_analog.service import NiAnalogEmulator  # noqa: PLC0415  (an extra)
    except ImportError as error:
        raise DriverUnavailable(
            device=_NAME,
            saw=f"no Python package '{error.name}'",
            expected="nidaqmx with its gRPC extra, 1.7 or newer",
            remedy="install kinopix[ni]",
        ) from error
    return NiAnalogEmulator(settings, bench)


plugin = TransportPlugin(
    summary="NI analogue inputs behind a gRPC device server: a detector's voltage and the sync",
    settings=NiAnalogEmulatorSettings,
    open=open_emulator,
)
"""Found as ``kinopix.transports: ni-analog-emulator``."""
