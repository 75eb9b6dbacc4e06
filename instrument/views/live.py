"""The run as it goes on, in the terminal: where the object is, and its image in half blocks."""

import time
from collections.abc import Callable
from threading import Lock
from typing import Final, Self

import numpy as np
from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.progress import Progress
from rich.table import Table
from rich.text import Text

from instrument.session import BlockEvent, Event, ImageEvent, TrackingEvent
from instrument.views.blocks import half_blocks, lit_part, sparkline
from instrument.views.terminal import ERR
from instrument.views.trace import Trace
from protocols import Floats

_PRINT_INTERVAL_S = 1.0
_OTHER_LINES = 3  # of the terminal's height: progress bars, and one that stays free
_LEAST_WIDTH = 70  # columns from which on figures stand beside the image
_FIGURES_WIDTH = 36


class LiveView:
    """Shows motion and image below progress bars: a listener for a run that ``LiveAnalysis`` follows.

    Where there is no terminal it prints a line of figures each second at most.
    """

    name: Final = "the live view"

    def __init__(self, bars: Progress, *, console: Console = ERR, now_s: Callable[[], float] = time.monotonic) -> None:
        """Prepare; nothing is drawn before it is entered.

        Args:
            bars: progress bars that nobody else has started; drawn above.
            console: where to draw.
            now_s: the time, by which printed lines are thinned out.
        """
        self._bars = bars
        self._console = console
        self._now_s = now_s
        self._printed_s = -np.inf
        self._lock = Lock()
        self._trace = Trace()
        self._image: Floats | None = None
        self._last: TrackingEvent | None = None
        self._counts: tuple[float, float] | None = None
        self._most_counts: float | None = None
        self._live: Live | None = None
        if console.is_terminal:
            # Five pictures a second: drawing holds the interpreter, which the acquisition needs too.
            self._live = Live(console=console, refresh_per_second=5, get_renderable=self._renderable)

    def __call__(self, event: Event) -> None:
        """Take what the live analysis tells."""
        if isinstance(event, TrackingEvent | ImageEvent):
            self.show(event)
        elif isinstance(event, BlockEvent) and event.block is not None and event.block.valid.any():
            lit = event.block.values[event.block.valid]
            with self._lock:
                self._counts = float(lit.mean()), float(lit.max())

    def hold_against(self, most_counts: float) -> None:
        """Hold counts of a pattern against the highest number that is counted linearly."""
        self._most_counts = most_counts

    def show(self, event: TrackingEvent | ImageEvent) -> None:
        """Take an event, from any thread; it is drawn when it is time."""
        with self._lock:
            if isinstance(event, ImageEvent):
                self._image = event.image
                return
            self._trace.add(event.displacement_px, event.sigma_px)
            self._last = event
        if self._live is None:
            now_s = self._now_s()
            if event.final or now_s - self._printed_s >= _PRINT_INTERVAL_S:
                self._printed_s = now_s
                self._console.print(self._figures(event), soft_wrap=True)

    def __enter__(self) -> Self:
        """Start to draw."""
        if self._live is not None:
            self._live.start()
        return self

    def __exit__(self, *exc: object) -> None:
        """Leave the last picture on the screen."""
        if self._live is not None:
            self._live.stop()

    def _figures(self, event: TrackingEvent) -> str:
        last = self._trace.last_px
        where = "" if last is None else "".join(f"{name} {words}, " for name, words in self._places())
        return (
            f"frame {event.frame}: {where}{event.images} images, {event.images_skipped} skipped, "
            f"{event.frames_dropped} frames dropped"
        )

    def _places(self) -> list[tuple[str, str]]:
        """Where the object is along x and y, and how certain that is, where it is known."""
        both = zip("xy", self._trace.last_px or (), self._trace.last_sigma_px, strict=False)
        return [
            (name, f"{place:+.2f} px" if np.isnan(sigma) else f"{place:+.2f} \u00b1 {sigma:.2f} px")
            for name, place, sigma in both
        ]

    def _light(self) -> list[str]:
        """What the newest block says of the light."""
        if self._counts is None:
            return []
        mean, brightest = self._counts
        lines = [f"light  {mean:.3g} a pattern, brightest {brightest:.3g}"]
        if self._most_counts:
            lines.append(f"       {100 * brightest / self._most_counts:.0f} % of the linear limit")
        return lines

    def _renderable(self) -> RenderableType:
        with self._lock:
            last, image, places = self._last, self._image, self._trace.displacement_px.copy()
            light = self._light()
        if last is None:
            return self._bars
        width, height = self._console.size
        beside = width >= _LEAST_WIDTH
        room = width - _FIGURES_WIDTH - 2 if beside else width - 1
        words = [
            f"frame  {last.frame}",
            *(f"{name}  {place}" for name, place in self._places()),
            *([f"{name} {sparkline(places[:, axis], 12)}" for axis, name in enumerate("xy")] if len(places) else []),
            *light,
            f"images {last.images}, {last.images_skipped} skipped",
            *([f"{last.frames_dropped} frames dropped by this view"] if last.frames_dropped else []),
        ]
        if image is None:
            return Group(self._bars, Text("\n".join(words), no_wrap=True))
        lines = height - _OTHER_LINES - (0 if beside else len(words))
        side = max(2, min(room, 2 * lines, len(image)))
        top, left, part = lit_part(image, side)
        side = min(side - side % 2, part)
        if part < len(image):
            words.append(f"shown  x {left} to {left + part - 1}, y {top} to {top + part - 1} px")
        drawn = half_blocks(
            image[top : top + part, left : left + part],
            side,
            colour=self._console.color_system is not None and not self._console.no_color,
        )
        text = Text("\n".join(words), no_wrap=True, overflow="ellipsis")
        if not beside:
            return Group(self._bars, text, drawn)
        grid = Table.grid(padding=(0, 2))
        grid.add_row(drawn, text)
        return Group(self._bars, grid)
