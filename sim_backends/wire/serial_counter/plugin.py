"""Entry point: ``transport = "serial-counter-emulator"`` of a counter."""

import serial

from protocols import BenchContext, InputError, TransportPlugin
from sim_backends.wire.seen_edges import photon_bench_of
from sim_backends.wire.serial_counter.box import CounterBox
from sim_backends.wire.serial_counter.settings import SerialCounterEmulatorSettings
from sim_backends.wire.serial_port import emulated_port

_NAME = "serial-counter-emulator"


def open_box(settings: SerialCounterEmulatorSettings, context: BenchContext) -> serial.SerialBase:
    """Give an open port to a counter on the context's optical bench.

    Raises:
        InputError: bench.toml has no ``[scene]`` that counts photons, or ``pty`` on a bench in virtual time or a system without.
    """
    bench = photon_bench_of(context, _NAME)
    box = CounterBox(settings, bench).box
    if not settings.pty:
        return emulated_port(box, _NAME)
    if not bench.settings.realtime:
        raise InputError(
            device=_NAME,
            saw="a pseudo-terminal on a bench in virtual time",
            expected="time that passes for the operating system too",
            remedy="set realtime = true in [scene], or leave pty out",
        )
    try:
        from sim_backends.wire.serial_counter.terminal import TerminalPort  # noqa: PLC0415 (no such module on Windows)
    except ImportError as error:
        raise InputError(
            device=_NAME,
            saw="a system without pseudo-terminals",
            expected="Linux or macOS",
            remedy="leave pty out: the emulator then is an object in this program",
        ) from error
    return TerminalPort(box)


plugin = TransportPlugin(
    summary="serial counter behind a pyserial port or a pseudo-terminal, on the optical bench",
    settings=SerialCounterEmulatorSettings,
    open=open_box,
)
"""Found as ``kinopix.transports: serial-counter-emulator``."""
