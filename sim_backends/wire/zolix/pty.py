"""A controller behind a pseudo-terminal: a device path in real time, for programs that open a port by name."""

import os
import select
import threading
import tty
from collections.abc import Generator
from contextlib import contextmanager

from protocols import InputError
from sim_backends.bench import RealTimeClock
from sim_backends.wire.zolix.controller import Controller

_LONGEST_WAIT_S = 0.02
"""How long the pump may sleep when nothing is to be expected."""


@contextmanager
def serve_pty(controller: Controller) -> Generator[str]:
    """Serve a controller on a new pseudo-terminal and give the path of its device (POSIX only).

    Raises:
        InputError: the controller lives in virtual time, which nobody at the other end would share.
    """
    if not isinstance(controller.clock, RealTimeClock):
        raise InputError(
            device="stage emulator",
            saw="a pseudo-terminal in virtual time",
            expected="a clock that really waits",
            remedy="set realtime = true in the [scene] table of bench.toml",
        )
    ours, theirs = os.openpty()
    tty.setraw(theirs)
    stop, stopped = os.pipe()
    pump = threading.Thread(target=_pump, args=(controller, ours, stop), name="zolix-pty", daemon=True)
    pump.start()
    try:
        yield os.ttyname(theirs)
    finally:
        os.write(stopped, b".")
        pump.join()
        for end in (ours, theirs, stop, stopped):
            os.close(end)


def _pump(controller: Controller, ours: int, stop: int) -> None:
    """Carry bytes both ways until told to stop."""
    while True:
        next_s = controller.next_s()
        wait_s = _LONGEST_WAIT_S if next_s is None else next_s - controller.clock.now_s()
        ready, _, _ = select.select([ours, stop], [], [], min(max(wait_s, 0.0), _LONGEST_WAIT_S))
        if stop in ready or controller.vanished:
            return
        if ours in ready:
            controller.receive(os.read(ours, 1024))
        arrived = controller.send()
        if arrived:
            os.write(ours, arrived)
