"""What the page shows besides image and path, as values that are sent as JSON."""

from typing import Final, Literal

from pydantic import NonNegativeFloat, NonNegativeInt, PositiveFloat

from instrument.acquisition import CheckReport
from instrument.plan import Plan
from instrument.session import Snapshot
from instrument.web.desk import Wish
from protocols import DeviceIdentity, Frozen

VERSION: Final = 1
"""Version of this layout. A page of another version asks to be loaded anew."""


class DeviceLine(Frozen):
    """A device of the bench."""

    role: str
    """Its place: modulator, counter or stage."""
    identity: DeviceIdentity
    """Who it is."""


class CheckLine(Frozen):
    """One question that the plan was asked, and its answer."""

    name: str
    """What was looked at."""
    outcome: Literal["good", "warning", "error"]
    """``error`` stops a run before it starts."""
    message: str
    """The answer, with its numbers."""


class PlanLine(Frozen):
    """What is to be done, or is done."""

    words: str
    """The plan in one line."""
    frames: NonNegativeInt
    """Frames of the run."""
    run_time_s: NonNegativeFloat
    """From the first pattern to the end of the last."""
    frame_time_s: PositiveFloat
    """From one frame to the next."""
    image_size: NonNegativeInt
    """Image pixels a side."""

    @classmethod
    def of(cls, plan: Plan, words: str) -> "PlanLine":
        """Say what the page needs of a plan."""
        return cls(
            words=words,
            frames=plan.frames,
            run_time_s=plan.run_time_s,
            frame_time_s=plan.frame_time_s,
            image_size=plan.image_size,
        )


class LightLine(Frozen):
    """Counts against what the counter counts linearly."""

    mean_hz: NonNegativeFloat
    """Mean count rate of the newest block."""
    brightest_hz: NonNegativeFloat
    """Of its brightest pattern."""
    run_brightest_hz: NonNegativeFloat
    """Of the brightest pattern of the run so far."""
    limit_hz: PositiveFloat
    """Highest count rate at which counts are linear, as the counter has it."""


class LiveLine(Frozen):
    """What the live analysis has done."""

    frames: NonNegativeInt = 0
    """Frames followed."""
    frames_dropped: NonNegativeInt = 0
    """Of those, frames that it lost because it was late. The recording has them."""
    images: NonNegativeInt = 0
    """Images made."""
    images_skipped: NonNegativeInt = 0
    """Images that were due and not made."""
    x_px: float | None = None
    """Displacement of the newest frame along x (right); None before the first."""
    y_px: float | None = None
    """The same along y (down)."""
    sigma_x_px: float | None = None
    """Standard uncertainty along x; None where none is known."""
    sigma_y_px: float | None = None
    """The same along y."""
    along_mm: float | None = None
    """The same along the stage's axis; None where the bench was not calibrated."""


class PageState(Frozen):
    """All of it."""

    kind: Literal["state"] = "state"
    version: int = VERSION
    """Of this layout."""
    time_s: float
    """When it was sent, seconds since 1970."""
    title: str
    """What is shown: the bench, or the folder."""
    offers: tuple[Wish, ...] = ()
    """What the page may ask for now; empty where it may only look on."""
    control: bool = False
    """Whether it may ask for anything at all."""
    doing: str = "at rest"
    """What the bench is about, in a few words."""
    notice: str = ""
    """The answer to the last wish."""
    devices: tuple[DeviceLine, ...] = ()
    """The devices of the bench."""
    px_per_mm: float | None = None
    """Image scale, by the bench's calibration."""
    plan: PlanLine | None = None
    """The plan."""
    checks: tuple[CheckLine, ...] = ()
    """What the plan was asked."""
    run: Snapshot | None = None
    """Where the run stands; None before the first."""
    runs: NonNegativeInt = 0
    """Runs so far: with another number, image and path begin anew."""
    light: LightLine | None = None
    """Counts; None before the first, and where the detector does not count."""
    live: LiveLine = LiveLine()
    """The live analysis."""


def check_lines(report: CheckReport) -> tuple[CheckLine, ...]:
    """Give a check report as the page shows it."""
    return tuple(CheckLine(name=c.name, outcome=c.outcome, message=c.message) for c in report.checks)
