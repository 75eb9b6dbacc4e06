"""What bench.toml may say about the USB-CTR board, doubts of its protocol included."""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field, NonNegativeFloat, PositiveFloat, PositiveInt

from drivers.h10682.detector import Head
from drivers.usb_ctr.codec import BASE_CLOCK_HZ, MAX_COUNT_RATE_HZ
from protocols import Frozen

CounterNumber = Annotated[int, Field(ge=0, le=7)]
TimerNumber = Annotated[int, Field(ge=0, le=3)]


class EdgeTimer(Frozen):
    """A timer output wired to a second counter input, which then times the sync edges."""

    timer: TimerNumber = 1
    """Number of the timer output (TMR)."""

    counter: CounterNumber = 1
    """Number of the counter input (CTR) that it is wired to."""

    period_ticks: PositiveInt = 9
    """The timer runs at 96 MHz / (period_ticks + 1): 9 gives 9.6 MHz, edge times in steps of 104 ns."""

    @property
    def tick_s(self) -> float:
        """Time between two pulses, in seconds."""
        return (self.period_ticks + 1) / BASE_CLOCK_HZ


class UsbCtrSettings(Frozen):
    """Wiring and doubts of an H10682 on a USB-CTR04 or USB-CTR08. The modulator's sync goes to CLKI."""

    serial: str | None = None
    """Serial number of the board; None where only one is plugged in."""

    fpga_image: Path | None = None
    """The maker's FPGA image, loaded where the board has none (after each power-up). Relative to bench.toml. None takes the one
    that the maker's library for Linux has installed."""

    counter: CounterNumber = 0
    """Number of the counter input of the photon pulses."""

    photon_edge: Literal["rising", "falling"] = "rising"
    """Edge of the photon pulse that counts."""

    debounce_code: Annotated[int, Field(ge=0, le=16)] = 16
    """The code that means "no debounce". The maker's library sends 16; another public driver says 0, which by the maker's
    table is 500 ns and would swallow every photon. ``run_self_test`` shows which is true on the board at hand."""

    scan_done_mask: Literal[0x20, 0x40] = 0x20
    """Status bit of an ended scan: 0x20 is likelier, 0x40 is that of output scans in the maker's library. ``run_self_test``
    shows it."""

    first_samples: Annotated[int, Field(ge=0, le=2)] = 1
    """Samples before the first bin. 1: the first edge gives the sample "start to first edge". 2: the board samples at the start
    of the scan too [U]. Prove it with the loopback of the how-to: the bright bin must be the bright pattern."""

    sync_counter: CounterNumber | None = None
    """Number of a counter input that the sync is wired to as well (a T-piece on CLKI); it counts every edge. None: not wired.

    Runs above 4 kHz then come in full packets, 78 transfers a second at 20 kHz instead of 20,000."""

    edge_timer: EdgeTimer | None = None
    """Times the edges, where a timer output is wired to a counter input; None gives no edge times."""

    counter_dead_time_s: NonNegativeFloat = 1 / MAX_COUNT_RATE_HZ
    """Dead time of the counter input in seconds [I]: it counts to 48 MHz, so pulses of 10 ns are at its limit."""

    max_sync_rate_hz: PositiveFloat = 100e3
    """Highest rate of sync edges [I]: the maker's library keeps 100 kHz."""

    head: Head = Field(default_factory=Head)
    """Detector at the counter's input."""
