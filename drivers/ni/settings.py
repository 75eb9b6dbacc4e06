"""What bench.toml may say about the NI counter."""

from typing import Self

from pydantic import Field, NonNegativeFloat, PositiveFloat, model_validator

from drivers.h10682.detector import Head
from drivers.ni.tasks import Edge
from protocols import Frozen


class NiSettings(Frozen):
    """Wiring and doubts of an H10682 on a NI board. Lines without a leading slash belong to ``device``."""

    device: str = "Dev1"
    """The board's name in NI MAX."""

    counter: str = "ctr0"
    """Name of the counter that counts the photon pulses."""

    photon_terminal: str = "PFI8"
    """Line of the photon pulses. Never with a digital filter: the fastest one swallows their 10 ns."""

    sync_terminal: str = "PFI9"
    """Line of the modulator's sync output: the sample clock."""

    sync_edge: Edge = "rising"
    """The edge that opens a bin."""

    sync_filter_s: PositiveFloat | None = None
    """Digital filter of the sync line; None is off. X series: 90 ns, 5.12 us, 2.56 ms; M series: 125 ns, 6.425 us, 2.55 ms."""

    arm_terminal: str | None = None
    """A separate sequence-start line that arms the counters; None arms them in software, before the modulator starts."""

    edge_counter: str | None = "ctr1"
    """Second counter, on the same clock, that times the sync edges; None gives no edge times."""

    timebase: str = "100MHzTimebase"
    """Onboard timebase that the second counter counts (M-series boards: 80MHzTimebase or 20MHzTimebase)."""

    timebase_hz: PositiveFloat = 100e6
    """Rate of the timebase, in Hz."""

    prevent_duplicates: bool = True
    """Duplicate-count prevention. Without it older boards store nothing for a bin without photons, and all later bins shift."""

    counter_dead_time_s: NonNegativeFloat | None = None
    """Pulse pairs that the counter merges, in seconds. None takes a quarter of the board's timebase as the fastest source, as
    duplicate-count prevention wants it: 40 ns at 100 MHz (X series), 50 ns at 80 MHz (M series)."""

    max_sync_rate_hz: PositiveFloat = 100e3
    """Highest rate of sync edges that this driver accepts [I]; the mirrors are slower anyhow."""

    buffer_s: PositiveFloat = 10.0
    """Part of a run that the host's buffer holds, in seconds; when it is full, counting stops rather than overwrites."""

    head: Head = Field(default_factory=Head)
    """Detector at the counter's input."""

    @model_validator(mode="after")
    def _lines_differ(self) -> Self:
        if self.arm_terminal == self.sync_terminal:
            raise ValueError(
                "arm_terminal is the sync line: whether the first edge is then a sample depends on the board; "
                "use a line of its own, or leave arm_terminal out"
            )
        if self.photon_terminal == self.sync_terminal:
            raise ValueError("photon_terminal and sync_terminal are the same line")
        if self.edge_counter == self.counter:
            raise ValueError("edge_counter and counter are the same counter")
        return self

    def line(self, name: str) -> str:
        """Full name of a line, such as ``/Dev1/PFI8``.

        >>> NiSettings().line("PFI8")
        '/Dev1/PFI8'
        """
        return name if name.startswith("/") else f"/{self.device}/{name}"
