"""What the page shows: told by the events of a run and by who holds the bench, asked by each viewer."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from threading import Lock
from typing import Any, Final

import numpy as np

from instrument.acquisition import CheckReport, Devices
from instrument.plan import Plan
from instrument.session import BlockEvent, Event, ImageEvent, Instrument, Run, TrackingEvent
from instrument.views import Trace, about_in_words, plan_in_words
from instrument.web.desk import Wish
from instrument.web.frames import image_body
from instrument.web.state import DeviceLine, LightLine, LiveLine, PageState, PlanLine, check_lines
from protocols import Floats

_POINTS: Final = 2048


@dataclass(frozen=True)
class NewImage:
    """The newest image, as it is sent."""

    sequence: int
    """Its number, from 1."""
    body: bytes
    """As ``frames.image_body`` gives it."""
    made_s: float
    """When the newest count in it was handed over, seconds since 1970."""


@dataclass(frozen=True, eq=False)
class NewPath:
    """The path so far."""

    generation: int
    """With another generation its first points have changed."""
    points: Floats
    """``(n, 5)`` seconds, x and y in px, and the standard uncertainty of both, NaN where none is known."""


def _known(sigma_px: float) -> float | None:
    return sigma_px if np.isfinite(sigma_px) else None


class Board:
    """Keeps what is shown. A listener of runs: none of its methods waits for a viewer.

    Memory is constant: one image, a path of at most 2,048 points, and the findings that a snapshot keeps.
    """

    name: Final = "the page"

    def __init__(self, title: str, *, control: bool = False, now_s: Callable[[], float] = time.time) -> None:
        """Show a bench at rest, without any device.

        Args:
            title: what is shown.
            control: whether pages may ask for anything.
            now_s: seconds since 1970.
        """
        self.control = control
        """Whether pages may ask for anything."""
        self._now_s = now_s
        self._lock = Lock()
        self._shown: dict[str, Any] = {"title": title, "control": control}
        self._run: Run | None = None
        self._plan: Plan | None = None
        self._instrument_scale: tuple[float, float] | None = None  # px/mm, degrees
        self._limit_hz: float | None = None
        self._brightest_hz = 0.0
        self._handed_over_s = 0.0
        self._live = LiveLine()
        self._image: NewImage | None = None
        self._images = 0
        self._trace = Trace(_POINTS)
        self._generation = 0
        self._version = 0
        self._wake: Callable[[], None] | None = None

    # Who holds the bench tells:

    def show_bench(self, instrument: Instrument) -> None:
        """Show who the devices are, and the calibration. Asks the devices: to be called by who holds them."""
        devices: Devices = instrument.devices
        scale, angle = instrument.px_per_mm, instrument.axis_angle_deg
        with self._lock:
            self._limit_hz = instrument.counter.limits.max_count_rate_hz if "counter" in devices.by_role else None
            self._instrument_scale = None if scale is None or angle is None else (scale, angle)
            lines = [DeviceLine(role=role, identity=identity) for role, identity in devices.identities().items()]
            self._shown |= {"devices": tuple(lines), "px_per_mm": scale}
        self._changed()

    def show_plan(self, plan: Plan, report: CheckReport) -> None:
        """Show a plan and what it was asked."""
        with self._lock:
            self._plan = plan
            words = [about_in_words(plan), plan_in_words(plan)]
            line = PlanLine.of(plan, ": ".join(part for part in words if part))
            self._shown |= {"plan": line, "checks": check_lines(report)}
        self._changed()

    def show_run(self, run: Run) -> None:
        """Show a run that begins; image and path of the one before are taken away."""
        with self._lock:
            self._run = run
            self._shown["runs"] = self._shown.get("runs", 0) + 1
        self._changed()

    def prepare(self) -> None:
        """Take away image, path and counts of the run before; to be called before the next one is started."""
        with self._lock:
            self._run, self._image, self._live, self._brightest_hz = None, None, LiveLine(), 0.0
            self._trace = Trace(_POINTS)
            self._generation += 1
            self._shown |= {"light": None, "notice": ""}
        self._changed()

    def say(
        self, doing: str | None = None, *, notice: str | None = None, offers: tuple[Wish, ...] | None = None
    ) -> None:
        """Say what the bench is about, what became of the last wish, and what may be wished for now."""
        with self._lock:
            if doing is not None:
                self._shown["doing"] = doing
            if notice is not None:
                self._shown["notice"] = notice
            if offers is not None:
                self._shown["offers"] = offers if self.control else ()
        self._changed()

    # The run tells:

    def __call__(self, event: Event) -> None:
        """Take an event of the run."""
        match event:
            case BlockEvent():
                self._take_block(event)
            case ImageEvent():
                self._take_image(event)
            case TrackingEvent():
                self._take_path(event)
            case _:
                pass  # the run's snapshot has it
        self._changed()

    def _take_block(self, event: BlockEvent) -> None:
        block, plan = event.block, self._plan
        with self._lock:
            self._handed_over_s = self._now_s()
        if block is None or plan is None or self._limit_hz is None:
            return
        counts = block.values[block.valid]
        if not len(counts) or np.any(counts % 1) or np.any(counts < 0):  # a detector that does not count
            return
        with self._lock:
            brightest_hz = float(counts.max()) / plan.picture_time_s
            self._brightest_hz = max(self._brightest_hz, brightest_hz)
            self._shown["light"] = LightLine(
                mean_hz=float(counts.mean()) / plan.picture_time_s,
                brightest_hz=brightest_hz,
                run_brightest_hz=self._brightest_hz,
                limit_hz=self._limit_hz,
            )

    def _take_image(self, event: ImageEvent) -> None:
        body = image_body(event.image, event.frame)
        with self._lock:
            self._images += 1
            self._image = NewImage(self._images, body, self._handed_over_s)

    def _take_path(self, event: TrackingEvent) -> None:
        with self._lock:
            stride = self._trace.stride
            self._trace.add(event.displacement_px, event.sigma_px)
            self._generation += self._trace.stride != stride
            last = self._trace.last_px
            if last is not None and not np.isfinite(last).all():
                last = None
            self._live = LiveLine(
                frames=event.frame,
                frames_dropped=event.frames_dropped,
                images=event.images,
                images_skipped=event.images_skipped,
                x_px=None if last is None else last[0],
                y_px=None if last is None else last[1],
                sigma_x_px=_known(self._trace.last_sigma_px[0]),
                sigma_y_px=_known(self._trace.last_sigma_px[1]),
                along_mm=None if last is None else self._along_mm(*last),
            )

    def _along_mm(self, x_px: float, y_px: float) -> float | None:
        if self._instrument_scale is None:
            return None
        px_per_mm, angle_deg = self._instrument_scale
        angle = np.radians(angle_deg)
        return float(x_px * np.cos(angle) + y_px * np.sin(angle)) / px_per_mm

    # Viewers ask:

    def listen(self, wake: Callable[[], None] | None) -> None:
        """Call a function at each change, from whichever thread; it must return at once. None calls nobody any more."""
        self._wake = wake

    @property
    def version(self) -> int:
        """Goes up by each change of anything."""
        return self._version

    @property
    def image(self) -> NewImage | None:
        """The newest image; None before the first."""
        return self._image

    @property
    def path(self) -> NewPath:
        """The path so far."""
        with self._lock:
            places_px, sigma_px = self._trace.displacement_px.copy(), self._trace.sigma_px.copy()
            stride, generation = self._trace.stride, self._generation
            frame_s = 0.0 if self._plan is None else self._plan.frame_time_s
        time_s = (np.arange(len(places_px)) * stride + 0.5) * frame_s
        return NewPath(generation, np.column_stack([time_s, places_px, sigma_px]).astype(np.float64))

    @property
    def state(self) -> PageState:
        """Everything else, as it is now."""
        with self._lock:
            shown, run, live = dict(self._shown), self._run, self._live
        return PageState(time_s=self._now_s(), run=None if run is None else run.snapshot, live=live, **shown)

    @property
    def over(self) -> bool:
        """Whether no run goes on."""
        run = self._run
        return run is None or run.done

    def _changed(self) -> None:
        with self._lock:
            self._version += 1
            wake = self._wake
        if wake is not None:
            wake()
