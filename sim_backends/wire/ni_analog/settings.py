"""The ``[counter.emulator]`` table of ``transport = "ni-analog-emulator"``."""

from typing import Literal

from protocols import Frozen
from sim_backends.bench.bounds import Factor, Hertz, Index, Level, Offset, Seconds, Seed


class NiAnalogEmulatorSettings(Frozen):
    """One board, a detector and its preamplifier. None of these figures was measured [I]."""

    device: str = "Dev1"
    """The board's name."""

    product: str = "PCIe-6361"
    """Type of the board."""

    max_rate_hz: Hertz = 1_000_000.0
    """Samples a second of all channels together (of each, where they are sampled at once)."""

    simultaneous: bool = False
    """Whether all channels are sampled at once."""

    volts_per_light: Factor = 1e-3
    """Voltage for one count, or one lit pixel, in a bin."""

    offset_v: Offset = 0.0
    """Voltage in darkness."""

    noise_v: Level = 0.002
    """White noise of each sample of the detector."""

    settle_s: Seconds = 2e-6
    """Time constant with which the preamplifier follows."""

    seed: Seed = 0
    """Of the noise."""

    sync_high_v: Factor = 3.3
    """Level of the sync pulses."""

    sync_width_s: Seconds = 5e-6
    """Length of a sync pulse."""

    polarity: Literal["positive", "negative"] = "positive"
    """Sign of the signal with more light."""

    range_v: Factor = 10.0
    """Where the inputs clip."""

    overrun_at_read: Index | None = None
    """A fault: from this read on the board has overwritten samples (-200279)."""

    gone_at_read: Index | None = None
    """A fault: from this read on the board is unplugged, and every call about it fails (-201003)."""

    reserved: bool = False
    """A fault: another program holds the inputs (-50103)."""
