"""One fault and what the instrument must answer."""

from dataclasses import dataclass
from typing import Literal, TypeAlias

from instrument.plan import Plan
from protocols import KinopixError
from tests.support.benches import SMALL

ErrorType: TypeAlias = type[KinopixError]


@dataclass(frozen=True, kw_only=True)
class Row:
    """A row of the table. The defaults are those of a run that nothing disturbs."""

    fault: str
    """What goes wrong, in words; the row's name."""

    modulator: Literal["simulated", "alp", "dlpc900"] = "simulated"
    counter: Literal["simulated", "ni", "ni-analog", "usb-ctr", "serial-counter"] = "simulated"
    stage: Literal["simulated", "mc600", "sc300", "zaber", "grbl"] = "simulated"
    keys: str = ""
    """Lines of the faulty device's own table."""

    emulator: str = ""
    """Lines of its emulator's table."""

    scene: str = ""
    """Lines of ``[scene]``."""

    frames: int = 40

    pattern_rate_hz: float = SMALL.pattern_rate_hz
    """Slower for a modulator that is."""

    error: ErrorType | None = None
    """What the run raises."""

    after: ErrorType | None = None
    """What came first, where ``error`` is that the bench could not be made safe."""

    at_opening: bool = False
    """Whether the bench does not even open."""

    says: tuple[str, ...] = ()
    """Parts of the error's sentence or, where there is none, of the audit's notes."""

    kept: int | None = None
    """Patterns in the recording; None: all. 0: no recording, or only raw counts."""

    verdict: Literal["good", "flagged", "partial", "failed"] = "good"

    gaps: tuple[int, ...] | None = ()
    """Patterns whose edge is missing, by the audit; None: too many to write down."""

    doubles: tuple[int, ...] | None = ()
    """Patterns with a surplus edge, likewise."""

    masked: tuple[int, ...] | Literal["all"] = ()
    """Frames that are left out, beside one that was begun and not ended."""

    counts: Literal["same", "alike", "wrong"] = "same"
    """Frames that are not masked, against a run of the same seed without the fault: the same to the bit; the same within the
    noise, where the fault changes the noise itself; or wrong, which the counts alone cannot show."""

    again: Literal["good", "as before"] | ErrorType | None = "as before"
    """The next run on the same open bench; None: as another row of the same family has it."""

    closing: ErrorType | None = None
    """What closing the bench raises: a device that is gone cannot be made safe."""

    @property
    def plan(self) -> Plan:
        """The run."""
        return SMALL.model_copy(update={"frames": self.frames, "pattern_rate_hz": self.pattern_rate_hz})

    @property
    def patterns(self) -> int:
        """Patterns that should be in the recording."""
        return 6 * self.frames if self.kept is None else self.kept

    @property
    def faulty(self) -> Literal["modulator", "counter", "stage"]:
        """The table that ``keys`` and ``emulator`` belong to."""
        if self.modulator != "simulated":
            return "modulator"
        return "stage" if self.stage != "simulated" else "counter"
