"""Entry point: ``transport = "dlpc900-emulator"`` of a modulator."""

from protocols import BenchContext, TransportPlugin
from sim_backends.bench import bench_of
from sim_backends.wire.dlpc900.device import EmulatedDlpc900
from sim_backends.wire.dlpc900.settings import Dlpc900EmulatorSettings


def open_device(settings: Dlpc900EmulatorSettings, context: BenchContext) -> EmulatedDlpc900:
    """Give an open HID device whose mirrors stand on the context's optical bench.

    Raises:
        InputError: bench.toml has no ``[scene]``.
    """
    return EmulatedDlpc900(settings, bench_of(context, "dlpc900-emulator"))


plugin = TransportPlugin(
    summary="TI DLPC900 behind HID reports, showing its pictures on the optical bench",
    settings=Dlpc900EmulatorSettings,
    open=open_device,
)
"""Found as ``kinopix.transports: dlpc900-emulator``."""
