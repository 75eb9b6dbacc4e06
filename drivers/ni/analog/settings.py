"""What bench.toml can tell the driver."""

from typing import Literal, Self

from pydantic import NonNegativeFloat, PositiveFloat, PositiveInt, model_validator

from protocols import Frozen


class NiAnalogSettings(Frozen):
    """The ``[counter]`` table for ``driver = "ni-analog"``."""

    device: str = "Dev1"
    """The board's name in NI MAX."""

    signal_channel: str = "ai0"
    """Analogue input of the detector."""

    sync_channel: str = "ai1"
    """Analogue input of the modulator's sync, sampled by the same task."""

    terminal: Literal["default", "rse", "nrse", "diff"] = "default"
    """How both inputs are connected."""

    sample_rate_hz: PositiveFloat = 500_000.0
    """Samples a second and channel, on the board's own clock."""

    range_v: PositiveFloat = 10.0
    """Range of both inputs, from minus to plus this, in volts. At 99 % of it a bin counts as overloaded."""

    polarity: Literal["positive", "negative"] = "positive"
    """Sign of the signal with more light: a bare anode gives negative ones."""

    offset_v: float = 0.0
    """Signal in darkness, in volts: taken off every value. Measure it with the shutter closed."""

    sync_threshold_v: PositiveFloat = 1.5
    """Level of the sync at which an edge is seen, in volts."""

    sync_hysteresis_v: PositiveFloat = 0.5
    """Depth below the threshold to which the sync must fall before the next edge, in volts."""

    settle_s: NonNegativeFloat = 15e-6
    """Time after each edge that is left out, in seconds: mirrors (about 13 us) and preamplifier."""

    least_samples: PositiveInt = 4
    """Samples that a bin must have behind its settling; a faster run is refused."""

    buffer_s: PositiveFloat = 10.0
    """Part of a run that the host's buffer holds, in seconds."""

    detector: str = "analogue detector"
    """Name of the detector, for the recording."""

    @model_validator(mode="after")
    def _one_that_can_be(self) -> Self:
        if self.signal_channel == self.sync_channel:
            raise ValueError("signal_channel and sync_channel are the same input")
        if not self.sync_hysteresis_v < self.sync_threshold_v < self.range_v:
            raise ValueError("sync_hysteresis_v must be below sync_threshold_v, and that below range_v")
        return self

    @property
    def settle_samples(self) -> int:
        """Samples after each edge that are left out: an edge is known to one sample, so one more than the time holds."""
        return int(self.settle_s * self.sample_rate_hz) + 1
