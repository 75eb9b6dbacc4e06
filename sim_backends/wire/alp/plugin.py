"""Entry point of the ALP emulator: ``transport = "alp-emulator"`` of a modulator whose driver calls an ALP-4 library."""

from protocols import BenchContext, TransportPlugin
from sim_backends.bench import bench_of
from sim_backends.wire.alp.board import EmulatedAlpBoard
from sim_backends.wire.alp.library import AlpLibrary
from sim_backends.wire.alp.settings import AlpEmulatorSettings


def open_library(settings: AlpEmulatorSettings, context: BenchContext) -> AlpLibrary:
    """Give the function table of a library with one board, on the context's optical bench.

    Raises:
        InputError: bench.toml has no ``[scene]``.
    """
    if settings.owner_file is not None:
        settings = settings.model_copy(update={"owner_file": context.folder / settings.owner_file})
    return AlpLibrary(EmulatedAlpBoard(settings, bench_of(context, "alp-emulator")))


plugin = TransportPlugin(
    summary="ALP-4 library with an emulated V-7000 board, on the optical bench",
    settings=AlpEmulatorSettings,
    open=open_library,
)
"""Found as ``kinopix.transports: alp-emulator``."""
