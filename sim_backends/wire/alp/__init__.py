"""An ALP-4 library without a board: the C functions, states, memory, timing rules and error codes of a ViALUX V-7000.

Written from the hardware sheet alone (``dlp7000.md``, sections 3, 7.1 and 8), never from a driver.
"""

from sim_backends.wire.alp.board import EmulatedAlpBoard
from sim_backends.wire.alp.library import AlpLibrary
from sim_backends.wire.alp.plugin import open_library
from sim_backends.wire.alp.settings import AlpEmulatorSettings

__all__ = ["AlpEmulatorSettings", "AlpLibrary", "EmulatedAlpBoard", "open_library"]
