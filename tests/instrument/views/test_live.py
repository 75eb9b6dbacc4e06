"""The run as it goes on, in the terminal."""

import io
import re

import numpy as np
import pytest
from rich.console import Console
from rich.progress import Progress

from instrument.acquisition import AlignedBlock
from instrument.session import BlockEvent, ImageEvent, TrackingEvent
from instrument.views.blocks import half_blocks, lit_part, sparkline
from instrument.views.live import LiveView
from instrument.views.trace import Trace


def _tracked(frame: int, *, final: bool = False) -> TrackingEvent:
    places_px = np.arange(frame - 10.0, frame)[:, None] * [0.5, -0.25]
    return TrackingEvent(
        frame=frame, displacement_px=places_px, frames_dropped=2, images=5, images_skipped=3, final=final
    )


def test_a_sparkline_goes_from_the_lowest_to_the_highest_block() -> None:
    assert sparkline(np.arange(8.0), 8) == "▁▂▃▄▅▆▇█ +0.0 to +7.0 px"
    assert sparkline(np.arange(1000.0), 4) == "▁▃▆█ +0.0 to +999.0 px"
    assert sparkline(np.zeros(3), 8) == "▁▁▁ +0.0 to +0.0 px"


def test_an_image_is_two_greys_a_character() -> None:
    """Upper half white over black, lower half black over half grey (16/31 of 255 is 131)."""
    text = half_blocks(np.array([[2.0, 2.0], [0.0, 0.0], [0.0, 0.0], [1.0, 1.0]]).repeat(2, axis=1), 4)
    assert text.plain == "▀▀▀▀\n▀▀▀▀\n"
    assert [str(span.style) for span in text.spans] == [
        "rgb(255,255,255) on rgb(0,0,0)",
        "rgb(0,0,0) on rgb(131,131,131)",
    ]


def test_a_large_image_is_averaged_down() -> None:
    """128 px on 60 characters: two or three pixels each, none left out."""
    image = np.zeros((128, 128))
    image[:, 64:] = 1.0
    lines = half_blocks(image, 60, colour=False).plain.split("\n")
    assert lines == [" " * 30 + "█" * 30] * 30


def test_without_colours_five_shades_have_to_do() -> None:
    ramp = np.linspace(0, 1, 5)[None].repeat(2, axis=0)
    assert half_blocks(np.pad(ramp, ((0, 3), (0, 0))), 5 - 1, colour=False).plain.count("\n") == 1


def test_a_trace_keeps_the_whole_way_in_constant_memory() -> None:
    trace = Trace(most=8)
    for first in range(0, 100, 10):
        trace.add(np.arange(first, first + 10.0)[:, None] * [1.0, 2.0])
    assert trace.displacement_px[:, 0].tolist() == [0.0, 16.0, 32.0, 48.0, 64.0, 80.0, 96.0]
    assert trace.last_px == (99.0, 198.0)
    assert np.isnan(trace.sigma_px).all()
    trace = Trace(most=8)
    trace.add(np.zeros((6, 2)), np.arange(6.0)[:, None] * [0.5, 0.25])
    assert trace.sigma_px.tolist() == [[0.5 * k, 0.25 * k] for k in range(6)]
    assert trace.last_sigma_px == (2.5, 1.25)


def test_without_a_terminal_a_line_of_figures_is_printed_each_second_at_most() -> None:
    out, times = io.StringIO(), iter([0.0, 0.4, 0.9, 1.1, 1.2])
    with LiveView(Progress(), console=Console(file=out), now_s=lambda: next(times)) as view:
        for frame in (10, 20, 30, 40):
            view(_tracked(frame))
        view(_tracked(50, final=True))
    assert out.getvalue().splitlines() == [
        f"frame {frame}: x {x} px, y {y} px, 5 images, 3 skipped, 2 frames dropped"
        for frame, x, y in ((10, "+4.50", "-2.25"), (40, "+19.50", "-9.75"), (50, "+24.50", "-12.25"))
    ]


def test_a_place_is_told_with_its_uncertainty_where_it_is_known() -> None:
    out = io.StringIO()
    event = _tracked(10).model_copy(update={"sigma_px": np.array([[np.nan, np.nan]] * 9 + [[0.125, np.nan]])})
    with LiveView(Progress(), console=Console(file=out)) as view:
        view(event)
    assert out.getvalue().startswith("frame 10: x +4.50 \u00b1 0.12 px, y -2.25 px, 5 images")


@pytest.fixture
def terminal() -> Console:
    """A terminal of 80 x 24."""
    return Console(file=io.StringIO(), force_terminal=True, width=80, height=24, color_system="truecolor", _environ={})


def _block(values: list[float]) -> BlockEvent:
    none = np.zeros(0, np.int64)
    counts = np.array(values)
    return BlockEvent.of(AlignedBlock(0, counts, np.isfinite(counts), None, none, none, none))


def _drawn(console: Console, image: np.ndarray) -> list[str]:
    """The lines of the last picture of a run with that image."""
    bars = Progress(console=console)
    bars.add_task("patterns counted", total=10)
    with LiveView(bars, console=console) as view:
        view.hold_against(250.0)
        view(_tracked(10))
        view(_block([10.0, 30.0, 125.0, float("nan")]))
        view(ImageEvent(frame=20, image=image))
        view(_tracked(30))  # without an image: the last one stays
    assert isinstance(console.file, io.StringIO)
    drawn = re.sub(r"\x1b\[[0-9;?]*[a-zA-Z]", "", console.file.getvalue())
    return [line.rstrip() for line in drawn[drawn.rindex("patterns counted") :].splitlines()]


def test_in_a_terminal_of_80_by_24_image_way_light_and_counters_are_drawn(terminal: Console) -> None:
    """24 lines less 3 are 42 px; beside them stand the figures."""
    image = np.zeros((64, 64))
    image[8:40, 16:44] = 1.0
    lines = _drawn(terminal, image)
    assert sum("▀" in line for line in lines) == 21
    assert len(lines) <= 24
    assert max(len(line) for line in lines) <= 80
    words = "\n".join(lines)
    for said in (
        "frame  30",
        "x  +14.50 px",
        "y  -7.25 px",
        "x ▁",
        "y █",
        "light  55 a pattern, brightest 125",
        "50 % of the linear limit",
        "images 5, 3 skipped",
        "2 frames dropped by this view",
        "shown  x 8 to 55, y 0 to 47 px",
    ):
        assert said in words


def test_without_colours_the_image_is_a_picture_in_characters(terminal: Console) -> None:
    plain = Console(
        file=io.StringIO(),
        force_terminal=True,
        width=80,
        height=24,
        no_color=True,
        color_system="truecolor",
        _environ={},
    )
    image = np.zeros((32, 32))
    image[8:24, 4:12] = 1.0
    lines = _drawn(plain, image)
    assert [line.index("█") for line in lines if "█" * 8 in line] == [4] * 8


def test_in_a_narrow_terminal_figures_stand_above_the_image() -> None:
    narrow = Console(
        file=io.StringIO(), force_terminal=True, width=40, height=30, color_system="truecolor", _environ={}
    )
    lines = _drawn(narrow, np.eye(64))
    first = next(row for row, line in enumerate(lines) if "▀" in line)
    assert any("frame  30" in line for line in lines[:first])
    assert max(len(line) for line in lines) <= 40


def test_of_a_large_image_the_part_with_the_object_is_shown() -> None:
    """30 px and 8 px around them are 46 px, 48 by steps of 8; its middle at row 35 and column 115 is shown as far as it goes."""
    image = np.zeros((128, 128))
    image[20:50, 100:128] = 1.0
    assert lit_part(image, 42) == (8, 80, 48)
    assert lit_part(image, 64) == (0, 64, 64)
    assert lit_part(image, 128) == (0, 0, 128)
    assert lit_part(np.ones((128, 128)), 42) == (0, 0, 128)
    assert lit_part(np.zeros((128, 128)), 42) == (0, 0, 128)
    image[3, 3] = 9.0
    assert lit_part(image, 42) == (8, 80, 48), "one wild pixel changes nothing"
