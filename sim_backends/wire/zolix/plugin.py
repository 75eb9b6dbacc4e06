"""Entry points of the stage controllers: ``transport = "mc600-emulator"`` or ``"sc300-emulator"`` of a stage."""

from protocols import BenchContext, TransportPlugin
from sim_backends.bench import bench_of
from sim_backends.wire.serial_port import EmulatedPort, emulated_port
from sim_backends.wire.zolix.mc600 import mc600_controller
from sim_backends.wire.zolix.sc300 import sc300_controller
from sim_backends.wire.zolix.settings import Mc600Settings, Sc300Settings


def open_mc600(settings: Mc600Settings, context: BenchContext) -> EmulatedPort:
    """Give an open port to an MC600 whose axis carries the object of the context's optical bench.

    Raises:
        InputError: bench.toml has no ``[scene]``.
    """
    bench = bench_of(context, "mc600-emulator")
    return emulated_port(mc600_controller(settings, bench.clock, bench.carry), "mc600-emulator")


def open_sc300(settings: Sc300Settings, context: BenchContext) -> EmulatedPort:
    """Give an open port to an SC300 whose axis carries the object of the context's optical bench.

    Raises:
        InputError: bench.toml has no ``[scene]``.
    """
    bench = bench_of(context, "sc300-emulator")
    return emulated_port(sc300_controller(settings, bench.clock, bench.carry), "sc300-emulator")


mc600 = TransportPlugin(
    summary="Zolix MC600 behind a pyserial port, carrying the object of the optical bench",
    settings=Mc600Settings,
    open=open_mc600,
)
"""Found as ``kinopix.transports: mc600-emulator``."""

sc300 = TransportPlugin(
    summary="Zolix SC300 behind a pyserial port, carrying the object of the optical bench",
    settings=Sc300Settings,
    open=open_sc300,
)
"""Found as ``kinopix.transports: sc300-emulator``."""
