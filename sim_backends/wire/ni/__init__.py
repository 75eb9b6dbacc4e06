"""An NI X-series counter board behind a gRPC device server, for the unmodified ``nidaqmx`` client.

Written from the hardware sheet alone (``h10682-daq.md``, sections 4, 11 and 12), never from a driver. Nothing here needs
``nidaqmx`` until an emulator is opened.
"""

from sim_backends.wire.ni.plugin import open_emulator, plugin
from sim_backends.wire.ni.settings import NiEmulatorSettings

__all__ = ["NiEmulatorSettings", "open_emulator", "plugin"]
