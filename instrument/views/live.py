"""The run as it goes on, in the terminal: where the object is, and its image in half blocks."""

import time
from collections.abc import Callable
from itertools import groupby
from threading import Lock
from typing import Final, Self

import numpy as np
from rich.console import Console, Group, RenderableType
from rich.live import Live
from rich.progress import Progress
from rich.style import Style
from rich.text import Text

from instrument.session import Event, ImageEvent, TrackingEvent
from instrument.views.terminal import ERR
from instrument.views.trace import Trace
from protocols import Floats

_BARS = "▁▂▃▄▅▆▇█"
_SHADES = " ░▒▓█"
_GREYS = 32  # few enough that neighbours are often equal and are drawn at once
_PRINT_INTERVAL_S = 1.0
_OTHER_LINES = 7  # of the terminal's height: progress bars, trajectory, counters


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
        self._live: Live | None = None
        if console.is_terminal:
            # Five pictures a second: drawing holds the interpreter, which the acquisition needs too.
            self._live = Live(console=console, refresh_per_second=5, get_renderable=self._renderable)

    def __call__(self, event: Event) -> None:
        """Take what the live analysis tells."""
        if isinstance(event, TrackingEvent | ImageEvent):
            self.show(event)

    def show(self, event: TrackingEvent | ImageEvent) -> None:
        """Take an event, from any thread; it is drawn when it is time."""
        with self._lock:
            if isinstance(event, ImageEvent):
                self._image = event.image
                return
            self._trace.add(event.displacement_px)
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
        where = "" if last is None else f"x {last[0]:+.2f} px, y {last[1]:+.2f} px, "
        return (
            f"frame {event.frame}: {where}{event.images} images, {event.images_skipped} skipped, "
            f"{event.frames_dropped} frames dropped"
        )

    def _renderable(self) -> RenderableType:
        with self._lock:
            last, image, places = self._last, self._image, self._trace.displacement_px.copy()
        if last is None:
            return self._bars
        width, height = self._console.size
        parts: list[RenderableType] = [self._bars, Text(self._figures(last))]
        if len(places):
            lines = (f"{name} {sparkline(places[:, axis], width - 24)}" for axis, name in enumerate("xy"))
            parts += [Text(line, no_wrap=True) for line in lines]
        if image is not None:
            side = max(2, min(width - 1, 2 * (height - _OTHER_LINES), len(image)))
            parts.append(half_blocks(image, side - side % 2, colour=self._console.color_system is not None))
        return Group(*parts)


def sparkline(series: Floats, width: int) -> str:
    """Draw a series as one line of blocks, lowest to highest value, with both figures behind it."""
    index = np.linspace(0, len(series) - 1, max(1, min(width, len(series)))).round().astype(np.int64)
    low, high = float(series.min()), float(series.max())
    span = max(high - low, 1e-9)
    level = np.minimum(((series[index] - low) / span * len(_BARS)).astype(np.int64), len(_BARS) - 1)
    return "".join(_BARS[k] for k in level.tolist()) + f" {low:+.1f} to {high:+.1f} px"


def half_blocks(image: Floats, side: int, *, colour: bool = True) -> Text:
    """Draw a square image, 0 to its brightest pixel, on ``side`` columns and half as many lines.

    Args:
        image: ``(m, m)``.
        side: even, at most m; the image is averaged down to it.
        colour: two greys a character; without, five shades of one.
    """
    small = _smaller(image, side)
    small = np.clip(small / max(float(small.max()), 1e-30), 0, 1)
    text = Text(no_wrap=True)
    if not colour:
        shade = ((small[0::2] + small[1::2]) / 2 * (len(_SHADES) - 1)).round().astype(np.int64)
        return text.append("\n".join("".join(_SHADES[k] for k in line) for line in shade.tolist()))
    grey: list[list[int]] = ((small * (_GREYS - 1)).round() * 255 / (_GREYS - 1)).astype(np.int64).tolist()
    for upper, lower in zip(grey[0::2], grey[1::2], strict=True):
        for (above, below), run in groupby(zip(upper, lower, strict=True)):
            style = Style(color=f"rgb({above},{above},{above})", bgcolor=f"rgb({below},{below},{below})")
            text.append("▀" * len(list(run)), style)
        text.append("\n")
    return text


def _smaller(image: Floats, side: int) -> Floats:
    """Average an image down to ``side`` rows and columns of whole pixels."""
    edge = np.arange(side) * len(image) // side
    count = np.diff(edge, append=len(image))
    summed = np.add.reduceat(np.add.reduceat(image, edge, axis=0), edge, axis=1)
    averaged: Floats = summed / np.outer(count, count)
    return averaged
