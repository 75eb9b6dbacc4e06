"""Names of an emulated board's counters, terminals and timebases."""

from sim_backends.wire.ni.errors import (
    INVALID_DEVICE_ID,
    INVALID_TERMINAL,
    PHYSICAL_CHAN_DOES_NOT_EXIST,
    ROUTE_NOT_SUPPORTED,
    NiError,
)
from sim_backends.wire.ni.settings import NiEmulatorSettings

_TIMEBASES_HZ = {"100MHzTimebase": 100e6, "80MHzTimebase": 80e6, "20MHzTimebase": 20e6, "100kHzTimebase": 100e3}
_PFI_LINES = 16
_DEFAULT_SOURCES = ("PFI8", "PFI3", "PFI0", "PFI5")


class Terminals:
    """What can be named on a board, and what it is wired to."""

    def __init__(self, settings: NiEmulatorSettings) -> None:
        self._settings = settings
        x_series = [name for name in _TIMEBASES_HZ if name != "80MHzTimebase"]
        self.timebases_hz = {
            name: _TIMEBASES_HZ[name] for name in x_series if _TIMEBASES_HZ[name] <= settings.ci_max_timebase_hz
        }
        counters = [f"Ctr{n}{end}" for n in range(settings.counters) for end in ("Source", "Gate", "InternalOutput")]
        self.names = [f"PFI{n}" for n in range(_PFI_LINES)] + [*self.timebases_hz] + counters

    def of(self, device: str) -> list[str]:
        """All terminals of a device, in full."""
        return [f"/{device}/{name}" for name in self.names]

    def counters(self, device: str) -> list[str]:
        """All counters of a device."""
        return [f"{device}/ctr{n}" for n in range(self._settings.counters)]

    def counter(self, name: str) -> tuple[str, str]:
        """Device and counter of a physical channel.

        Raises:
            NiError: no such device or counter.
        """
        device, _, counter = name.strip().lstrip("/").partition("/")
        devices = {known.casefold(): known for known in self._settings.devices}
        if device.casefold() not in devices:
            raise NiError(INVALID_DEVICE_ID)
        device = devices[device.casefold()]
        if f"{device}/{counter.casefold()}" not in self.counters(device):
            raise NiError(PHYSICAL_CHAN_DOES_NOT_EXIST)
        return device, counter.casefold()

    def resolve(self, name: str, device: str) -> str:
        """Short name of a terminal, given as ``PFI8`` or ``/Dev1/PFI8``.

        Raises:
            NiError: no such terminal on the device, or none that can be routed to a counter.
        """
        short = name.strip()
        if short.startswith("/"):
            owner, _, short = short[1:].partition("/")
            if owner.casefold() != device.casefold():
                raise NiError(INVALID_TERMINAL)
        known = {terminal.casefold(): terminal for terminal in self.names}
        if short.casefold() not in known:
            raise NiError(INVALID_TERMINAL)
        terminal = known[short.casefold()]
        if terminal in self._settings.unroutable:
            raise NiError(ROUTE_NOT_SUPPORTED)
        return terminal

    @staticmethod
    def default_source(counter: str) -> str:
        """The terminal that a counter's source has before anyone chooses [R]."""
        return _DEFAULT_SOURCES[int(counter.removeprefix("ctr")) % len(_DEFAULT_SOURCES)]

    def is_line(self, terminal: str, line: str | None) -> bool:
        """Whether a cable on ``line`` (None: on any PFI) is on this terminal."""
        return terminal.startswith("PFI") if line is None else terminal.casefold() == line.casefold()
