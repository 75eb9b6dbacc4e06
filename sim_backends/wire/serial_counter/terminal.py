"""A pseudo-terminal between a program and an emulated device: a port that the operating system knows by name."""

import os
import select
import threading
import tty
from typing import Final

import serial

from sim_backends.wire.serial_box import SerialBox

_SLICE_S: Final = 0.002
"""Longest time that bytes lie on either side, in seconds."""


class TerminalPort(serial.Serial):
    """An open port on the slave side; a thread carries bytes between the master side and the box. Closing it ends both."""

    def __init__(self, box: SerialBox) -> None:
        """Open a pseudo-terminal.

        Raises:
            OSError: the system gives none.
        """
        self._box = box
        self._master, self._slave = os.openpty()
        tty.setraw(self._master)
        tty.setraw(self._slave)
        self._over = threading.Event()
        self._carrier = threading.Thread(target=self._carry, name="pseudo-terminal", daemon=True)
        super().__init__(os.ttyname(self._slave), timeout=0)
        self._carrier.start()

    def close(self) -> None:
        """Close the port, and the terminal behind it."""
        super().close()
        if not self._over.is_set():
            self._over.set()
            self._carrier.join(1.0)
            os.close(self._master)
            os.close(self._slave)

    def _carry(self) -> None:
        while not self._over.is_set():
            readable, _, _ = select.select([self._master], [], [], _SLICE_S)
            if readable:
                self._box.receive(os.read(self._master, 4096))
            data = self._box.send()
            while data:
                data = data[os.write(self._master, data) :]
