"""``kinopix count``: the count rate now."""

from math import isnan
from typing import TYPE_CHECKING, Annotated, Final

import typer

from instrument.cli.options import (
    BenchOption,
    ImageSizeOption,
    JsonOption,
    SuperpixelOption,
    print_json,
    refuse_no_amount,
)

if TYPE_CHECKING:
    from rich.table import Table
    from rich.text import Text

    from instrument.session import Counting

_BAR: Final = 40
"""Letters of the longest bar."""

_JSON_S: Final = 1.0
"""Seconds that are counted for ``--json`` where no time is asked for."""


def count(
    bench: BenchOption,
    picture: Annotated[
        str, typer.Option("--show", help="Picture on the modulator meanwhile: white, black, or as of `kinopix show`.")
    ] = "white",
    seconds: Annotated[
        float | None, typer.Option(help="How long to count; without it until Ctrl-C, with --json for 1 s.")
    ] = None,
    pattern_rate_hz: Annotated[float, typer.Option(help="Pictures a second: the bins of the histogram.")] = 20_000.0,
    image_size: ImageSizeOption = 128,
    superpixel: SuperpixelOption = 2,
    as_json: JsonOption = False,
) -> None:
    """Count the light of one picture: rate, bar against the linear limit, histogram. The stage is not touched.

    The modulator is opened too: its sync edges open and close the counter's bins.
    """
    from rich.live import Live

    from instrument.cli.libraries import tell_libraries
    from instrument.session import Instrument
    from instrument.session import count as count_light
    from instrument.views import ERR, OUT

    refuse_no_amount(pattern_rate_hz=pattern_rate_hz)
    roles = ("modulator", "counter")
    tell_libraries(bench, roles)
    if as_json and seconds is None:
        seconds = _JSON_S
    with Instrument.from_toml(bench, only=roles) as instrument, Live(console=ERR, transient=True) as live:
        counted = count_light(
            instrument,
            seconds,
            picture=picture,
            pattern_rate_hz=pattern_rate_hz,
            image_size=image_size,
            superpixel=superpixel,
            tell=lambda now: live.update(counting_table(picture, now)),
        )
    if as_json:
        print_json({"picture": picture, **counted.as_dict()})
    else:
        OUT.print(counting_table(picture, counted))


def counting_table(picture: str, counted: "Counting") -> "Table":
    """Give rate, bar and histogram as a table."""
    from instrument.views import figures_table, plain

    share = counted.share_of_limit
    colour = "green" if share < 0.5 else "yellow" if share <= 1 else "red"
    lit = 0 if isnan(share) else round(_BAR * min(share, 1.0))  # not a number without counts
    bar = plain("#" * lit + "." * (_BAR - lit) + f" {100 * share:.1f} % of the linear limit", colour)
    numbers, borders = counted.histogram()
    most = max(1.0, float(numbers.max(initial=0.0)))
    rows = {
        f"{low + 0.5:.0f} to {high - 0.5:.0f}": f"{'#' * round(_BAR * n / most):<{_BAR}} {n:.0f}"
        for n, low, high in zip(numbers, borders[:-1], borders[1:], strict=True)
    }
    figures: dict[str, str | Text] = {
        "rate": f"{counted.rate_hz:,.0f} +- {counted.sigma_hz:,.0f} counts/s",
        "a picture": f"{counted.rate_hz * counted.picture_time_s:.2f} counts in {counted.picture_time_s * 1e6:g} us",
        "linear limit": f"{counted.limit_hz:,.0f} counts/s",
        "": bar,
        "variance / mean": f"{counted.variance_over_mean:.3f}",
        "pictures": f"{len(counted.counts)}, by their counts:",
    }
    return figures_table(f"Counts, {picture} picture", {**figures, **rows})
