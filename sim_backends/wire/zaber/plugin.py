"""Entry point: ``transport = "zaber-emulator"`` of a stage."""

from protocols import BenchContext, TransportPlugin
from sim_backends.bench import bench_of
from sim_backends.wire.serial_port import EmulatedPort, emulated_port
from sim_backends.wire.zaber.device import ZaberDevice
from sim_backends.wire.zaber.settings import ZaberEmulatorSettings


def open_zaber(settings: ZaberEmulatorSettings, context: BenchContext) -> EmulatedPort:
    """Give an open port to a Zaber device whose axis carries the object of the context's optical bench.

    Raises:
        InputError: bench.toml has no ``[scene]``.
    """
    bench = bench_of(context, "zaber-emulator")
    return emulated_port(ZaberDevice(settings, bench.clock, bench.carry).box, "zaber-emulator")


plugin = TransportPlugin(
    summary="Zaber controller behind a pyserial port, carrying the object of the optical bench",
    settings=ZaberEmulatorSettings,
    open=open_zaber,
)
"""Found as ``kinopix.transports: zaber-emulator``."""
