"""How values show themselves: one line at a prompt, and a card with a picture in a notebook.

Pictures are written as they are, grey PNG and SVG curves, so that showing a value loads no plotting.
"""

from base64 import b64encode
from collections.abc import Mapping
from html import escape
from io import BytesIO
from typing import Final

import numpy as np

from protocols import Floats

_WIDTH: Final = 420
_HEIGHT: Final = 150
_POINTS: Final = 300
_COLOURS: Final = ("#0072b2", "#d55e00")  # the Okabe-Ito palette, as in all pictures
_LEAST_SIDE: Final = 192


def line(kind: str, *facts: str) -> str:
    """Give a value in one line.

    Args:
        kind: name of its type.
        facts: what is said of it; empty ones are left out.
    """
    return f"<{kind}: {', '.join(fact for fact in facts if fact)}>"


def card(title: str, rows: Mapping[str, str], *pictures: str) -> str:
    """Give a value as HTML: a heading, a table of two columns, and pictures beside it.

    Args:
        title: heading.
        rows: text by name. Both are taken as they stand: markup in them is shown, not obeyed.
        pictures: HTML of ``grey`` and ``curves``.
    """
    cells = "".join(
        f'<tr><th style="text-align:left;padding-right:1em">{escape(name)}</th>'
        f'<td style="text-align:left">{escape(text)}</td></tr>'
        for name, text in rows.items()
    )
    drawn = "".join(f"<div>{picture}</div>" for picture in pictures if picture)
    table = f"<table>{cells}</table>"
    return (
        f'<div><b>{escape(title)}</b><div style="display:flex;flex-wrap:wrap;gap:1.5em;align-items:flex-start">'
        f"{table}{drawn}</div></div>"
    )


def grey(image: Floats, what: str) -> str:
    """Give an image as HTML, grey from 0 to its brightest pixel; small ones are shown larger.

    Args:
        image: ``(rows, columns)``, row = y down.
        what: what it is, for those who do not see it.
    """
    from PIL import Image  # noqa: PLC0415 - most values are never shown

    top = float(np.nanmax(image, initial=0.0)) or 1.0
    pixels = np.round(np.clip(np.nan_to_num(image) / top, 0.0, 1.0) * 255).astype(np.uint8)
    file = BytesIO()
    Image.fromarray(pixels).save(file, "PNG", optimize=True)
    side = max(_LEAST_SIDE, image.shape[1])
    return (
        f'<img alt="{escape(what)}" width="{side}" style="image-rendering:pixelated" '
        f'src="data:image/png;base64,{b64encode(file.getvalue()).decode()}">'
    )


def curves(time_s: Floats, values: Floats, sigma: Floats | None, what: str, unit: str) -> str:
    """Give curves over time as HTML, with bands of two standard deviations.

    Args:
        time_s: ``(n,)``.
        values: ``(n, curves)``, at most two curves; what is not finite is left out.
        sigma: ``(n, curves)`` standard deviation; None draws no bands.
        what: what it is, for those who do not see it.
        unit: of the values.
    """
    step = max(1, len(time_s) // _POINTS)
    time_s, values = time_s[::step], values[::step]
    finite = values[np.isfinite(values)]
    if not len(finite):
        return ""
    low, high = min(0.0, float(finite.min())), max(float(finite.max()), 1e-9)
    end_s = float(time_s[-1]) or 1.0
    across = 46 + time_s / end_s * (_WIDTH - 56)

    def down(of: Floats) -> Floats:
        return 10 + (1 - (of - low) / (high - low)) * (_HEIGHT - 40)

    parts: list[str] = []
    for column, colour in zip(range(values.shape[1]), _COLOURS, strict=False):
        place = values[:, column]
        known = np.isfinite(place)
        if sigma is not None:
            reach = 2 * sigma[::step][:, column]
            sure = known & np.isfinite(reach)
            there = _points(across[sure], down(place[sure] - reach[sure]))
            back = _points(across[sure][::-1], down(place[sure] + reach[sure])[::-1])
            parts.append(f'<polygon points="{there} {back}" fill="{colour}" fill-opacity="0.25"/>')
        width = 3.5 - 2 * column
        parts.append(
            f'<polyline points="{_points(across[known], down(place[known]))}" fill="none" stroke="{colour}" '
            f'stroke-width="{width:g}"/>'
        )
    ground = float(down(np.array([0.0]))[0])
    parts.append(f'<line x1="46" x2="{_WIDTH - 10}" y1="{ground:.1f}" y2="{ground:.1f}" stroke="gray"/>')
    for value, y in ((high, 14.0), (low, _HEIGHT - 28.0)):
        parts.append(f'<text x="2" y="{y:g}" font-size="11" fill="gray">{value:.3g}</text>')
    under = f"{escape(unit)}; 0 to {end_s:.3g} s"
    parts.append(f'<text x="46" y="{_HEIGHT - 8}" font-size="11" fill="gray">{under}</text>')
    return f'<svg role="img" aria-label="{escape(what)}" width="{_WIDTH}" height="{_HEIGHT}">{"".join(parts)}</svg>'


def _points(across: Floats, down: Floats) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in zip(across.tolist(), down.tolist(), strict=True))
