"""Entry point: ``transport = "grbl-emulator"`` of a stage."""

from protocols import BenchContext, TransportPlugin
from sim_backends.bench import bench_of
from sim_backends.wire.grbl.board import GrblBoard
from sim_backends.wire.grbl.settings import GrblEmulatorSettings
from sim_backends.wire.serial_port import EmulatedPort, emulated_port


def open_grbl(settings: GrblEmulatorSettings, context: BenchContext) -> EmulatedPort:
    """Give an open port to a GRBL board, one axis of which carries the object of the context's optical bench.

    Raises:
        InputError: bench.toml has no ``[scene]``.
    """
    bench = bench_of(context, "grbl-emulator")
    return emulated_port(GrblBoard(settings, bench.clock, bench.carry).box, "grbl-emulator")


plugin = TransportPlugin(
    summary="GRBL 1.1 controller behind a pyserial port, carrying the object of the optical bench",
    settings=GrblEmulatorSettings,
    open=open_grbl,
)
"""Found as ``kinopix.transports: grbl-emulator``."""
