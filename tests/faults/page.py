"""The rows as docs/reference/faults.md shows them. ``python -m tests.faults.page`` prints all tables."""

from collections.abc import Iterator

from tests.faults.row import Row
from tests.faults.table import TABLE

_HEAD = "| fault | to try it | answer | kept | next run |\n|---|---|---|---|---|"


def line(row: Row) -> str:
    """One line of a table."""
    cells = (row.fault, _settings(row), _answer(row), _kept(row), _next(row))
    return "| " + " | ".join(cell.replace("|", "\\|") for cell in cells) + " |"


def tables() -> Iterator[str]:
    """Heading and table of each device."""
    for device, rows in TABLE.items():
        yield "\n".join([f"## {device}", "", _HEAD, *(line(row) for row in rows)])


def _settings(row: Row) -> str:
    parts = {
        f"[{row.faulty}]": row.keys,
        f"[{row.faulty}.emulator]": row.emulator,
        "[scene]": row.scene,
    }
    shown = [f"`{table} {' ; '.join(text.splitlines())}`" for table, text in parts.items() if text]
    text = "<br>".join(shown)
    return text if len(text) < 300 else "thirty `double-edge` in `[scene] faults`"


def _answer(row: Row) -> str:
    if row.error is not None:
        came = f", from `{row.after.__name__}`" if row.after else ""
        where = " at opening" if row.at_opening else ""
        return f"`{row.error.__name__}` ({row.error.exit_code}){where}{came}"
    notes = "; ".join(row.says)
    return f"{row.verdict}" + (f": {notes}" if notes else "")


def _kept(row: Row) -> str:
    if row.at_opening or row.patterns == 0:
        return "nothing was counted"
    kept = f"{row.patterns} of {6 * row.frames} patterns"
    if row.masked == "all":
        return f"{kept}, every frame masked"
    masked = f", {len(row.masked)} frame{'s' if len(row.masked) > 1 else ''} masked" if row.masked else ""
    return kept + masked + (", **not the counts of a good run**" if row.counts == "wrong" else "")


def _next(row: Row) -> str:
    if row.at_opening:
        return "open again"
    if row.again is None:
        return "as above"
    if isinstance(row.again, str):
        return row.again
    return f"`{row.again.__name__}`: open again"


if __name__ == "__main__":
    print("\n\n".join(tables()))  # noqa: T201
